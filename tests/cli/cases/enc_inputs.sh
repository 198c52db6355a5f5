# A folder, a pattern, a glob, a list and the files themselves are the same sequence.
quick=(nsdf-enc -q "${tiny[@]}" --no-verify --fps 24)
"${quick[@]}" -o folder.nsdf fixture/frames
"${quick[@]}" -o pattern.nsdf 'fixture/frames/metaballs_%04d.obj'
"${quick[@]}" -o glob.nsdf 'fixture/frames/*.obj'
"${quick[@]}" -o files.nsdf fixture/frames/*.obj
for file in fixture/frames/*.obj; do echo "$file"; done >list.txt
"${quick[@]}" -o list.nsdf list.txt
for way in pattern glob files list; do
    same folder.nsdf "$way.nsdf"
done

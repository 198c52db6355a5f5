# PLY frames are the same sequence by folder and by pattern, and the same surfaces as OBJ frames; errors name the place.
mkdir ply obj
nsdf-dec -q fixture/tiny.nsdf -o ply/d_%02d.ply --frames 0-1
nsdf-dec -q fixture/tiny.nsdf -o obj/d_%02d.obj --frames 0-1
quick=(nsdf-enc -q "${tiny[@]}" --no-verify --fps 24)
"${quick[@]}" -o ply.nsdf ply
"${quick[@]}" -o pattern.nsdf 'ply/d_%02d.ply'
same ply.nsdf pattern.nsdf
nsdf-cmp obj ply --csv --samples 500 | cut -d, -f6-12
cp -r ply cut
head -c 1000 ply/d_01.ply >cut/d_01.ply
fails 1 'cut/d_01.ply: byte 1000: the file ends' "${quick[@]}" -o cut.nsdf cut
no_leftovers . fixture ply obj cut ply.nsdf pattern.nsdf

# Rate, metadata, held frames, replaced segments; inputs stay as they are, and unknown chunks in the file.
cp fixture/tiny.nsdf tiny.nsdf
nsdf-mux tiny.nsdf -o same.nsdf 2>&1 | sed 's/[0-9]* bytes/some bytes/'
same tiny.nsdf same.nsdf
nsdf-mux -q tiny.nsdf --fps 60000/1001 --set title="Kugeln, \"weich\"" --set license=MIT --remove encoder -o set.nsdf
nsdf-mux --info set.nsdf | sed -n '/"rate"/p;/"metadata"/,$p'
nsdf-mux -q set.nsdf --set title=Balls --remove license -o set2.nsdf
nsdf-mux --info set2.nsdf | sed -n '/"metadata"/,$p'
nsdf-dec --info set2.nsdf | grep -A 3 metadata
diff <(nsdf-dec -q -o hash: tiny.nsdf | cut -d' ' -f1,3) <(nsdf-dec -q -o hash: set2.nsdf | cut -d' ' -f1,3) &&
    echo "the meshes are the same"
nsdf-mux -q tiny.nsdf --hold 3 -o held.nsdf
nsdf-dec -q -o hash: held.nsdf | cut -d' ' -f3 | tail -n 4 | sort -u | wc -l

nsdf-mux -q tiny.nsdf tiny.nsdf -o two.nsdf
nsdf-mux -q two.nsdf --segments 0 -o first.nsdf
nsdf-mux -q two.nsdf --replace 1 --with tiny.nsdf -o wrong.nsdf
nsdf-mux --info wrong.nsdf | grep -c '"first"'
fails 1 "the segments have 7 frames, and the other file has 6" nsdf-mux two.nsdf --replace 0 --with tiny.nsdf -o x.nsdf
fails 1 "segments 2 to 2 of a file that has segments 0 to 1" nsdf-mux two.nsdf --replace 2 --with tiny.nsdf -o x.nsdf
fails 1 "boxes differ: (" nsdf-mux tiny.nsdf "$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf" -o x.nsdf
fails 1 "frame rates differ: 24/1 and 60000/1001" nsdf-mux tiny.nsdf set.nsdf -o x.nsdf
fails 1 "cross-fade of 2 frames" nsdf-mux tiny.nsdf tiny.nsdf --fade 2 -o x.nsdf

# Unknown chunks: of all that the golden file has, none is lost.
golden=$(dirname "${BASH_SOURCE[0]}")/../../golden/v0.6/ok/unknown_chunks.nsdf
nsdf-mux -q "$golden" -o copy.nsdf
nsdf-mux --info "$golden" | grep '"type"'
diff <(nsdf-mux --info "$golden" | grep '"type"') <(nsdf-mux --info copy.nsdf | grep '"type"')
nsdf-mux -q "$golden" "$golden" -o twice.nsdf
nsdf-mux --info twice.nsdf | grep '"type"'
nsdf-mux --validate twice.nsdf

same tiny.nsdf fixture/tiny.nsdf
fails 2 "would replace an input" nsdf-mux tiny.nsdf -o ./tiny.nsdf
fails 2 "no output" nsdf-mux tiny.nsdf
fails 2 "no input" nsdf-mux -o x.nsdf
fails 2 "exclude each other" nsdf-mux tiny.nsdf --frames 1 --times 1 -o x.nsdf
fails 2 "go together" nsdf-mux tiny.nsdf --replace 1 -o x.nsdf
fails 2 "several files" nsdf-mux tiny.nsdf --fade 1 -o x.nsdf
fails 2 "there are frames 0 to 5" nsdf-mux tiny.nsdf --frames 2-6 -o x.nsdf
fails 2 "there are segments 0 to 0" nsdf-mux tiny.nsdf --segments 1 -o x.nsdf
fails 2 "out of range" nsdf-mux tiny.nsdf --times 5 -o x.nsdf
fails 2 "'9-3' is not a range" nsdf-mux tiny.nsdf --frames 9-3 -o x.nsdf
fails 2 "'nan' is not a range" nsdf-mux tiny.nsdf --times nan -o x.nsdf
fails 2 "'=5' is not KEY=VALUE" nsdf-mux tiny.nsdf --set =5 -o x.nsdf
fails 1 "not UTF-8" nsdf-mux tiny.nsdf --set "key=$(printf '\377')" -o x.nsdf
fails 1 "missing.nsdf: cannot be read: No such file" nsdf-mux missing.nsdf -o x.nsdf
fails 1 "a folder" nsdf-mux fixture -o x.nsdf
fails 1 "cannot write" nsdf-mux tiny.nsdf -o nowhere/x.nsdf
[ ! -e x.nsdf ] || give_up "a failed command left a file"
nsdf-mux --version | sed 's/[0-9].*/N/'

# What is cut, at segments' ends or inside them, joins to the same bytes, and every frame stays the mesh that it was.
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
hashes() {
    nsdf-dec -q --resolution 24 -o hash: "$@" | cut -d' ' -f3
}
segments() {
    nsdf-mux --info "$1" | sed -nE 's/.*("first".*), "smallest.*/\1/p'
}
# cut_and_join FILE FRAME: parts it behind that frame
cut_and_join() {
    nsdf-mux -q "$1" --frames "0-$2" -o left.nsdf
    nsdf-mux -q "$1" --frames "$(($2 + 1))-" -o right.nsdf
    nsdf-mux -q left.nsdf right.nsdf -o again.nsdf
    printf '%s: ' "$2"
    same "$1" again.nsdf
}

# Frames that do not follow each other are not mixed.
nsdf-mux -q "$walker" --frames 0-15 -o a.nsdf
nsdf-mux -q "$walker" --frames 10-30 -o b.nsdf
nsdf-mux -q "$walker" --frames 40- -o c.nsdf
nsdf-mux -v a.nsdf b.nsdf c.nsdf -o jumps.nsdf 2>&1 | sed "s/is [0-9.]* %/is N %/"
nsdf-mux --validate jumps.nsdf
segments jumps.nsdf
hashes jumps.nsdf | diff - <(hashes "$walker" --frames 0-15,10-30,40-47) && echo "every frame is what it was"
for frame in 5 15 20 33 36 40; do
    cut_and_join jumps.nsdf $frame
done

# Cut in one segment: it becomes one again.  Measured errors were those of all frames, and are lost.
nsdf-mux -q "$walker" --frames 16-36 -o b.nsdf
nsdf-mux -q "$walker" --frames 37- -o c.nsdf
nsdf-mux -q a.nsdf b.nsdf c.nsdf -o one.nsdf
segments one.nsdf
hashes one.nsdf | diff - <(hashes "$walker") && echo "every frame is what it was"

# Two models of a surface that goes on are mixed, when they are joined again too.
nsdf-mux -q "$walker" --frames 0-10 -o a.nsdf
nsdf-mux -q "$walker" --frames 12- -o b.nsdf
nsdf-mux -v a.nsdf b.nsdf -o mixed.nsdf 2>&1 | sed "s/is [0-9.]* %/is N %/"
segments mixed.nsdf
for frame in 5 10 30; do
    cut_and_join mixed.nsdf $frame
done

# Segments share a frame.
for file in jumps mixed; do
    nsdf-mux -q $file.nsdf --segments 0 -o left.nsdf
    nsdf-mux -q $file.nsdf --segments 1- -o right.nsdf
    nsdf-mux -q left.nsdf right.nsdf --shared -o again.nsdf
    same $file.nsdf again.nsdf
    nsdf-mux -q $file.nsdf --replace 1- --with right.nsdf -o again.nsdf
    same $file.nsdf again.nsdf
done

nsdf-mux jumps.nsdf --times 0.8-1.3 -o times.nsdf 2>&1
[ "$(hashes times.nsdf)" = "$(hashes jumps.nsdf --frames 19-32)" ] || give_up "other frames"
no_leftovers . fixture a.nsdf b.nsdf c.nsdf jumps.nsdf one.nsdf mixed.nsdf left.nsdf right.nsdf again.nsdf times.nsdf

# How many frames there are, and at what times, for several frame rates: 6 frames at 24 a second last 5/24 s.
for fps in 24 50 30 12 48 60000/1001 7; do
    nsdf-dec --fps "$fps" --resolution 8 -o hash: -q fixture/tiny.nsdf >hashes
    echo "--fps $fps: $(wc -l <hashes) frames at$(awk '{ printf " %.5f", $2 }' hashes)"
done
mkdir out
nsdf-dec --fps 48 --resolution 8 -q -o out/f_%03d.ply fixture/tiny.nsdf
no_leftovers out f_00{0..9}.ply f_010.ply
nsdf-dec --times 0,0.1 --resolution 8 -o hash: -q fixture/tiny.nsdf | wc -l
fails 2 --times nsdf-dec --times soon -o null: fixture/tiny.nsdf
fails 2 'out of range' nsdf-dec --times 0.5 -o null: fixture/tiny.nsdf
fails 2 'out of range' nsdf-dec --times=-1 -o null: fixture/tiny.nsdf
fails 2 'no frame 9' nsdf-dec --frames 4-9 -o null: fixture/tiny.nsdf
fails 2 --frames nsdf-dec --frames 3-x -o null: fixture/tiny.nsdf
nsdf-dec --frames 1-5/2,0 --resolution 8 -o hash: -q fixture/tiny.nsdf | awk '{ printf "%.5f\n", $2 }'

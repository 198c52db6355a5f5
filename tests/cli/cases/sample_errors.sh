nsdf-sample --help | head -n 1
fails 2 NAME nsdf-sample -o out
fails 2 no-such nsdf-sample no-such -o out
fails 2 --frames nsdf-sample knot --frames 0 -o out
fails 2 --resolution nsdf-sample knot --resolution 1 -o out
fails 2 --fps nsdf-sample knot --fps nan -o out
fails 2 FOLDER nsdf-sample knot
: >file
fails 1 file/out nsdf-sample knot --frames 1 -o file/out
code=0
(
    trap '' XFSZ
    ulimit -f 4
    nsdf-sample knot --frames 2 --resolution 24 -o out 2>limited
) || code=$?
[ "$code" = 1 ] || give_up "a file that does not fit ended with $code"
grep -q '^nsdf-sample: cannot write' limited || give_up "no message: $(<limited)"
no_leftovers out

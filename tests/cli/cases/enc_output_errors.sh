fails 1 nowhere nsdf-enc "${tiny[@]}" -o nowhere/a.nsdf fixture/frames
: >file
fails 1 file nsdf-enc "${tiny[@]}" -o file/a.nsdf fixture/frames
# A limit on the size of files stands for a full disk; an older file stays as it is.
mkdir out
cp fixture/tiny.nsdf out/a.nsdf
code=0
(
    trap '' XFSZ
    ulimit -f 1
    nsdf-enc "${tiny[@]}" -q --width 64 --no-verify -o out/a.nsdf fixture/frames 2>limited
) || code=$?
[ "$code" = 1 ] || give_up "a file that does not fit ended with $code"
no_leftovers out a.nsdf
same out/a.nsdf fixture/tiny.nsdf

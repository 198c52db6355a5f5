# So many steps would never end: the names must be tried before fitting.
fails 1 nowhere/a nsdf-enc "${tiny[@]}" --steps 1000000000 -o nowhere/a.nsdf fixture/frames
fails 1 nowhere/r nsdf-enc "${tiny[@]}" --steps 1000000000 --report nowhere/r.json -o a.nsdf fixture/frames
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
no_leftovers . file fixture limited out
if [ -w /dev/full ]; then
    fails 1 /dev/full nsdf-enc "${tiny[@]}" --no-verify -o /dev/full fixture/frames/metaballs_0000.obj
else
    echo "exit 1: /dev/full"
fi

code=0
nsdf-dec --frames 0 --format obj -o - fixture/tiny.nsdf >/dev/full 2>err || code=$?
[ "$code" = 1 ] || give_up "a full disk behind stdout ended with $code: $(<err)"
grep -q '^nsdf-dec: ' err || give_up "no message: $(<err)"
echo "stdout: exit 1"
# A limit on the size of files stands for a full disk.
mkdir out
code=0
(
    trap '' XFSZ
    ulimit -f 1
    nsdf-dec --frames 0-3 -o out/f_%04d.obj fixture/tiny.nsdf 2>limited
) || code=$?
[ "$code" = 1 ] || give_up "a file that does not fit ended with $code"
no_leftovers out

# Ctrl-C while bytes trickle in ends the command at once and leaves nothing behind.
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
serve "$walker" slow 2000
mkdir out
start_interruptible nsdf-dec -v "$url" -o out/walker_%02d.obj
wait_for_message kernels
kill -INT "$pid"
code=0
wait_for "$pid" 5 || code=$?
[ "$code" = 1 ] || give_up "ended with $code: $(<interrupted.err)"
grep -q ': interrupted$' interrupted.err || give_up "no word about it: $(<interrupted.err)"
no_leftovers out
serve_no_more

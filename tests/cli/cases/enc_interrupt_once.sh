# The first Ctrl-C stops fitting and writes a valid file; before fitting there is nothing to write yet, so wait longer.
mkdir out
for pause in 1 3 10; do
    start_interruptible nsdf-enc "${tiny[@]}" --no-verify --steps 100000000 -o out/a.nsdf fixture/frames
    sleep "$pause"
    kill -INT "$pid"
    code=0
    wait_for "$pid" 60 || code=$?
    [ "$code" = 0 ] && break
    no_leftovers out >/dev/null
done
[ "$code" = 0 ] || give_up "ended with $code: $(<interrupted.err)"
nsdf-dec -q --verify out/a.nsdf >verified
nsdf-dec -q --resolution 12 -o null: out/a.nsdf
no_leftovers out a.nsdf

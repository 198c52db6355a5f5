# A second Ctrl-C while the file is being verified leaves nothing either.
mkdir out
start_interruptible nsdf-enc "${tiny[@]}" --steps 100000000 --resolution 512 -o out/a.nsdf fixture/frames
for pause in 2 3 10; do # before fitting, one is enough to give up
    sleep "$pause"
    kill -INT "$pid" 2>/dev/null || break
    sleep 0.2
    kill -INT "$pid" 2>/dev/null || break
done
code=0
wait_for "$pid" 60 || code=$?
[ "$code" = 1 ] || give_up "ended with $code: $(<interrupted.err)"
no_leftovers out

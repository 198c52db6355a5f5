# The second Ctrl-C gives up and leaves nothing; an older file that was to be replaced stays as it is.
# SIGTERM counts as two.
mkdir out
cp fixture/tiny.nsdf out/old.nsdf
for name in new old; do
    start_interruptible nsdf-enc "${tiny[@]}" --steps 100000000 -o "out/$name.nsdf" fixture/frames
    sleep 2
    kill -TERM "$pid"
    code=0
    wait_for "$pid" 60 || code=$?
    [ "$code" = 1 ] || give_up "ended with $code: $(<interrupted.err)"
    grep -q 'nothing was written' interrupted.err || give_up "no word about it: $(<interrupted.err)"
done
no_leftovers out old.nsdf
same out/old.nsdf fixture/tiny.nsdf

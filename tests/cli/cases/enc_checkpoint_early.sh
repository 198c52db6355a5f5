# Ctrl-C ends fitting early and writes the file, as ever; the checkpoint stays, and the same command goes on from it.
command=(nsdf-enc "${tiny[@]}" --no-verify --steps 100000000 --checkpoint out/a.ckpt -o out/a.nsdf fixture/frames)
mkdir out
for pause in 1 3 10; do
    start_interruptible "${command[@]}"
    sleep "$pause"
    kill -INT "$pid"
    code=0
    wait_for "$pid" 60 || code=$?
    [ "$code" = 0 ] && break
done
[ "$code" = 0 ] || give_up "ended with $code: $(<interrupted.err)"
grep -q "'out/a.ckpt' stays" interrupted.err || give_up "no word about it: $(<interrupted.err)"
nsdf-dec -q --verify out/a.nsdf >verified
no_leftovers out a.ckpt a.nsdf
start_interruptible "${command[@]}"
wait_for_message "going on"
kill -TERM "$pid"
wait_for "$pid" 60 || true
grep -q "going on from 'out/a.ckpt': [1-9][0-9]* steps are done" interrupted.err || give_up "$(<interrupted.err)"
no_leftovers out a.ckpt a.nsdf

# A disk without room costs the checkpoints only; a limit on the size of files stands for it.
mkdir full
(
    trap '' XFSZ
    ulimit -f 4
    nsdf-enc "${tiny[@]}" -q --fps 24 --width 16 --checkpoint full/a.ckpt --checkpoint-every 1 -o full/a.nsdf \
        fixture/frames 2>limited
)
grep -q "cannot write 'full/a.ckpt'" limited || give_up "no word about it: $(head -n 3 limited)"
same full/a.nsdf fixture/tiny.nsdf
no_leftovers full a.nsdf

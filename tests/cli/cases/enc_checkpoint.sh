# A command that is killed goes on when it is repeated, and ends in the bytes of one that was not.
start_and_kill() { # COMMAND...: killed once some steps are in its checkpoint
    local tries=3000 steps=0
    "$@" --checkpoint out/a.ckpt --checkpoint-every 0 -o out/a.nsdf fixture/frames 2>killed.err &
    pid=$!
    while [ "$steps" -lt 40 ] && [ "$tries" -gt 0 ]; do
        kill -0 "$pid" 2>/dev/null || give_up "ended by itself: $(<killed.err)"
        sleep 0.02
        tries=$((tries - 1))
        [ -e out/a.ckpt ] && steps=$(od -An -tu8 -j 18 -N 8 out/a.ckpt | tr -d ' ')
    done
    kill -KILL "$pid"
    wait "$pid" 2>/dev/null || true
    [ "$steps" -ge 40 ] || give_up "no checkpoint of 40 steps: $(<killed.err)"
    rm -f out/.a.*.tmp-"$pid" # a killed command cannot remove its own
}

for model in "--layers 2 --width 16" "--blocks 60 --bones 3"; do
    mkdir out
    # The words of $model are options.
    # shellcheck disable=SC2206
    command=(nsdf-enc --samples 3000 --resolution 24 --threads 2 $model --steps 500 --batch-points 128
        --hard-samples off --no-verify)
    "${command[@]}" -q -o plain.nsdf fixture/frames
    start_and_kill "${command[@]}"
    no_leftovers out a.ckpt
    "${command[@]}" --checkpoint out/a.ckpt -o out/a.nsdf fixture/frames 2>resumed.err
    grep -qE "^nsdf-enc: going on from 'out/a.ckpt': [0-9]+ steps are done$" resumed.err ||
        give_up "does not say that it goes on: $(<resumed.err)"
    same out/a.nsdf plain.nsdf
    no_leftovers out a.nsdf
    rm -r out
done

# Without a break the checkpoint comes and goes.
mkdir out
nsdf-enc -q "${tiny[@]}" --checkpoint out/b.ckpt --checkpoint-every 0 -o out/b.nsdf --fps 24 fixture/frames
same out/b.nsdf fixture/tiny.nsdf
no_leftovers out b.nsdf

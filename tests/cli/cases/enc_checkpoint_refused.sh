# A checkpoint of another run, or a damaged one, is refused in one line and stays as it is.
command=(nsdf-enc "${tiny[@]}" --steps 100000000 --no-verify)
start_interruptible "${command[@]}" --checkpoint a.ckpt --checkpoint-every 0 -o a.nsdf fixture/frames
for ((i = 0; i < 3000; i++)); do
    if [ -e a.ckpt ]; then break; fi
    sleep 0.02
done
kill -TERM "$pid"
wait_for "$pid" 60 && give_up "an interrupt succeeded"
grep -q "nothing was written, but 'a.ckpt'" interrupted.err || give_up "no word about it: $(<interrupted.err)"
rm interrupted.out interrupted.err
cp a.ckpt good

refused() { # TEXT OPTION... FRAMES
    local text=$1
    shift
    cp a.ckpt before
    fails 1 "$text" "${command[@]}" --checkpoint a.ckpt -o a.nsdf "$@"
    cmp -s a.ckpt before || give_up "the checkpoint was changed"
    rm before
}

refused 'a.ckpt: the checkpoint was made with other options: steps of the blocks was 100000000 and is 9' --steps 9 \
    fixture/frames
refused 'seed was 1 and is 2' --seed 2 fixture/frames
refused 'width was 16 and is 20' --width 20 fixture/frames
refused 'blocks was 0 and is 50' --blocks 50 fixture/frames
refused '6 frames, now 3' --frames 0-2 fixture/frames
refused 'frame 1 where frame 2 is now' --frames 0,2-5,7 fixture/frames fixture/frames
mkdir other
cp fixture/frames/* other
sed -i '0,/^v /s/^v \([^ ]*\)/v 0.25/' other/metaballs_0003.obj
refused 'frame 3 differs' other
head -c 1000 good >a.ckpt
refused 'cut off after 1000 bytes' fixture/frames
: >a.ckpt
refused 'not a checkpoint' fixture/frames
cp good a.ckpt
flip a.ckpt 2000
refused 'its checksum does not match' fixture/frames
cp good a.ckpt
flip a.ckpt 9
refused 'layout 0' fixture/frames
cp fixture/frames/metaballs_0000.obj a.ckpt
refused 'not a checkpoint' fixture/frames

# Options that have no part in fitting may be others.
cp good a.ckpt
start_interruptible "${command[@]}" --threads 1 --fps 30 --resolution 30 --entropy none --checkpoint a.ckpt -o a.nsdf \
    fixture/frames
wait_for_message "going on"
kill -TERM "$pid"
wait_for "$pid" 60 || true
grep -q "going on from 'a.ckpt'" interrupted.err || give_up "did not go on: $(<interrupted.err)"
rm interrupted.out interrupted.err

# Names, before fitting.
fails 1 nowhere/a.ckpt "${command[@]}" --checkpoint nowhere/a.ckpt -o a.nsdf fixture/frames
fails 1 'not a file' "${command[@]}" --checkpoint other -o a.nsdf fixture/frames
fails 2 'another option names' "${command[@]}" --checkpoint a.nsdf -o a.nsdf fixture/frames
fails 2 'not a name' "${command[@]}" --checkpoint a.obj -o a.nsdf fixture/frames
fails 2 'seconds from 0 up' "${command[@]}" --checkpoint a.ckpt --checkpoint-every -1 -o a.nsdf fixture/frames
fails 2 'without --checkpoint' "${command[@]}" --checkpoint-every 5 -o a.nsdf fixture/frames
no_leftovers . a.ckpt fixture good other

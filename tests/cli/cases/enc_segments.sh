# A sequence in segments: the same bytes whatever the number of processes, one of which may die; and it decodes.
command=(nsdf-enc --blocks 40 --bones 2 --samples 2000 --resolution 24 --threads 1 --steps 200 --batch-points 64
    --block-radius 0.2 --segment 0.17 --fps 24)
nsdf-sample walker --frames 13 --resolution 20 --fps 24 -o frames 2>/dev/null
mkdir out
"${command[@]}" -v -o out/one.nsdf frames 2>one.err
segments=$(grep -c 'segment [0-9]* of [0-9]*, frames' one.err)
[ "$segments" = 3 ] || give_up "$segments segments for 13 frames: $(<one.err)"
no_leftovers out one.nsdf
"${command[@]}" -q --jobs 2 -o out/two.nsdf frames
same out/one.nsdf out/two.nsdf
"${command[@]}" -q --threads 3 -o out/two.nsdf frames
same out/one.nsdf out/two.nsdf
nsdf-dec --verify out/one.nsdf >/dev/null
[ "$(nsdf-dec --info --json out/one.nsdf | grep -c '"start"')" = "$segments" ] || give_up "segments are not in --info"

# What an interrupted run has done is there for the next.
"${command[@]}" -o out/three.nsdf frames 2>three.err &
pid=$!
for ((i = 0; i < 600; i++)); do
    ls out/three.nsdf.segments/*.part >/dev/null 2>&1 && break
    sleep 0.05
done
kill -TERM "$pid"
wait "$pid" && give_up "ended with success in spite of SIGTERM"
[ ! -e out/three.nsdf ] || give_up "wrote a file in spite of SIGTERM"
"${command[@]}" -o out/three.nsdf frames 2>resumed.err
grep -q "segments are there from an earlier run" resumed.err || give_up "does not go on: $(<resumed.err)"
same out/one.nsdf out/three.nsdf
no_leftovers out one.nsdf two.nsdf three.nsdf

# A process that dies loses its segment only, which is fitted again.
"${command[@]}" -o out/four.nsdf frames 2>four.err &
pid=$!
for ((i = 0; i < 600; i++)); do
    child=$(cut -d' ' -f1 "/proc/$pid/task/$pid/children" 2>/dev/null) && [ -n "$child" ] && break
    sleep 0.02
done
kill -KILL "$child"
wait "$pid" || give_up "did not survive a process of its own: $(<four.err)"
grep -q "is fitted again" four.err || give_up "says nothing of the process that died: $(<four.err)"
same out/one.nsdf out/four.nsdf
no_leftovers out one.nsdf two.nsdf three.nsdf four.nsdf

# A size is that of the whole file.
nsdf-enc -q --blocks 40 --bones 2 --samples 2000 --resolution 24 --threads 2 --steps 200 --batch-points 64 \
    --segment 0.17 --fps 24 --size 9000 -o out/size.nsdf frames
size=$(stat -c %s out/size.nsdf)
{ [ "$size" -le 9000 ] && [ "$size" -ge 8730 ]; } || give_up "--size 9000 gave $size bytes"

# A file in the place of the folder is told before all frames are looked over.
cp -r frames worse && echo 'f 1 2 3' >worse/zzz.obj && touch out/x.nsdf.segments
fails 1 "cannot make the folder 'out/x.nsdf.segments' for segments: File exists" "${command[@]}" -o out/x.nsdf worse
rm out/x.nsdf.segments
fails 1 "zzz.obj" "${command[@]}" -o out/x.nsdf worse
no_leftovers out one.nsdf two.nsdf three.nsdf four.nsdf size.nsdf

fails 2 "needs one fit" nsdf-enc --segment 0.17 --checkpoint out/c -o out/x.nsdf frames
fails 2 "'-1' is not a number of seconds" nsdf-enc --segment -1 -o out/x.nsdf frames
fails 2 "'0' is not a number from 1 to 256" nsdf-enc --jobs 0 -o out/x.nsdf frames

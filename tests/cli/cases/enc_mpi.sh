# Ranks of MPI give the bytes of one process, and so do those that are left when one is killed.
command -v mpirun >/dev/null || skip "no mpirun"
grep -q libmpi <<<"$(ldd "$(command -v nsdf-enc)")" || skip "built without MPI"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
command=(nsdf-enc --blocks 40 --bones 2 --samples 2000 --resolution 24 --threads 1 --steps 300 --batch-points 64
    --segment 0.17 --fps 24)
nsdf-sample walker --frames 13 --resolution 20 --fps 24 -o frames 2>/dev/null
mkdir out tmp
export TMPDIR=$PWD/tmp
"${command[@]}" -q -o out/one.nsdf frames
mpirun --oversubscribe -n 2 "${command[@]}" -q -o out/two.nsdf frames
same out/one.nsdf out/two.nsdf

# All ranks know where the frames around a missing file stand.
cp -r frames gap && rm "gap/$(ls gap | sed -n 6p)"
"${command[@]}" -q -o out/gap.nsdf gap
mpirun --oversubscribe -n 2 "${command[@]}" -q -o out/gaps.nsdf gap
same out/gap.nsdf out/gaps.nsdf
nsdf-dec --info out/gap.nsdf | grep frames
rm out/gap.nsdf out/gaps.nsdf

rank_one() {
    local pid
    for pid in $(pgrep -x nsdf-enc); do
        grep -qz '^OMPI_COMM_WORLD_RANK=1$' "/proc/$pid/environ" 2>/dev/null &&
            grep -qz "^$PWD/out/three.nsdf$" "/proc/$pid/cmdline" && echo "$pid" && return
    done
    return 0
}
mpirun --enable-recovery --oversubscribe -n 2 "${command[@]}" -v -o "$PWD/out/three.nsdf" frames 2>three.err &
mpi=$!
for ((i = 0; i < 200; i++)); do
    victim=$(rank_one)
    [ -n "$victim" ] && [ -d out/three.nsdf.segments ] && break
    sleep 0.02
done
sleep 0.1
kill -KILL "$victim"
wait "$mpi" || give_up "the ranks that are left do not end well: $(<three.err)"
grep -q "rank 1 on .* has died" three.err || give_up "says nothing of the death: $(<three.err)"
same out/one.nsdf out/three.nsdf
no_leftovers out one.nsdf two.nsdf three.nsdf
[ -z "$(find tmp -name 'nsdf-enc-*')" ] || give_up "the rank that was killed left $(find tmp -name 'nsdf-enc-*')"

# One fit is rank 0's; wrong usage ends all ranks.
mpirun --oversubscribe -n 2 nsdf-enc -q "${tiny[@]}" -o out/four.nsdf --fps 24 fixture/frames
same out/four.nsdf fixture/tiny.nsdf
mpirun --oversubscribe -n 2 nsdf-enc --jobs 0 -o out/x.nsdf frames 2>/dev/null && give_up "accepts --jobs 0"
rm -rf frames
mpirun --oversubscribe -n 2 "${command[@]}" -o out/x.nsdf frames 2>/dev/null && give_up "encodes nothing"
no_leftovers out one.nsdf two.nsdf three.nsdf four.nsdf

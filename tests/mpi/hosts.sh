#!/usr/bin/env bash
# Segments fitted by two hosts, which are network namespaces with names of their own, joined by a virtual cable: the
# bytes are those of one process, also when the rank on the other host is killed.
# usage: hosts.sh BIN FOLDER     BIN has the programs, FOLDER is for files; exit code 77 = cannot be run here
set -euo pipefail
bin=$(cd "$1" && pwd)
mkdir -p "$2"
cd "$2"
[ "$(id -u)" = 0 ] || { echo "needs root for network namespaces" && exit 77; }
for tool in mpirun ip unshare hostname; do
    command -v "$tool" >/dev/null || { echo "needs $tool" && exit 77; }
done
grep -q libmpi <<<"$(ldd "$bin/nsdf-enc")" || { echo "built without MPI" && exit 77; }
left=nsdf-l$$ right=nsdf-r$$
clean() {
    ip netns pids "$left" 2>/dev/null | xargs -r kill -KILL || true
    ip netns pids "$right" 2>/dev/null | xargs -r kill -KILL || true
    ip netns delete "$left" 2>/dev/null || true
    ip netns delete "$right" 2>/dev/null || true
}
trap clean EXIT
ip netns add "$left" 2>/dev/null || { echo "network namespaces cannot be made here" && exit 77; }
ip netns add "$right"
ip link add "l$$" netns "$left" type veth peer name "r$$" netns "$right"
ip -n "$left" address add 10.77.0.1/24 dev "l$$"
ip -n "$right" address add 10.77.0.2/24 dev "r$$"
for namespace in "$left" "$right"; do
    ip -n "$namespace" link set lo up
done
ip -n "$left" link set "l$$" up
ip -n "$right" link set "r$$" up

# What mpirun takes for ssh: the only other host is the right one.
cat >agent.sh <<END
#!/bin/sh
shift
exec ip netns exec $right unshare --uts sh -c 'hostname right; exec "\$@"' sh sh -c "\$*"
END
chmod +x agent.sh
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
run() { # ranks on the hosts 10.77.0.1 and 10.77.0.2
    ip netns exec "$left" unshare --uts sh -c 'hostname left; exec "$@"' sh \
        mpirun --enable-recovery --mca plm_rsh_agent "$PWD/agent.sh" --mca btl tcp,self \
        --mca btl_tcp_if_include 10.77.0.0/24 --mca oob_tcp_if_include 10.77.0.0/24 \
        --host 10.77.0.1:1,10.77.0.2:1 -n 2 "$@"
}
on_right() { # the process of rank 1
    for pid in $(ip netns pids "$right"); do
        if grep -qz '^OMPI_COMM_WORLD_RANK=1$' "/proc/$pid/environ" 2>/dev/null &&
            [ "$(cat "/proc/$pid/comm")" = nsdf-enc ]; then
            echo "$pid"
            return
        fi
    done
}

"$bin/nsdf-sample" walker --frames 25 --resolution 20 --fps 24 -o frames 2>/dev/null
command=("$bin/nsdf-enc" --blocks 40 --bones 2 --samples 2000 --resolution 24 --threads 1 --steps 1500
    --batch-points 64 --segment 0.17 --fps 24 "$PWD/frames")
"${command[@]}" -q -o one.nsdf
run "${command[@]}" -v -o two.nsdf 2>two.err
cmp one.nsdf two.nsdf
echo "two hosts give the bytes of one process"

run "${command[@]}" -v -o three.nsdf 2>three.err &
mpi=$!
for ((i = 0; i < 200; i++)); do
    victim=$(on_right)
    [ -n "$victim" ] && [ -d three.nsdf.segments ] && break
    sleep 0.05
done
sleep 1
kill -KILL "$victim"
wait "$mpi" || { echo "FAILED: mpirun ended with $?: $(cat three.err)" && exit 1; }
grep -q "rank 1 on right has died" three.err || { echo "FAILED: $(cat three.err)" && exit 1; }
cmp one.nsdf three.nsdf
echo "a host that dies loses only its segment"

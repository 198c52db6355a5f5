#!/usr/bin/env bash
# Encodes and decodes captured sequences.  They are not part of the project: without them the test is skipped (77).
# usage: real_sequences.sh BIN_FOLDER WORK_FOLDER DATA_FOLDER short|long
set -euo pipefail

usage='usage: real_sequences.sh BIN_FOLDER WORK_FOLDER DATA_FOLDER short|long'
bin=$(cd "${1:?$usage}" && pwd)
work=${2:?$usage}
data=${3:?$usage}
size=${4:?$usage}

if [ ! -x "$data/unpack" ] || ! command -v zstd >/dev/null; then
    echo "no sequences in $data, or no zstd to unpack them"
    exit 77
fi
if [ "$size" = long ] && [ "${NSDF_TEST_REAL:-0}" != 1 ]; then
    echo "set NSDF_TEST_REAL=1 to run this test"
    exit 77
fi
mkdir -p "$work"
# Two runs at once share the folder.
exec 9>"$work/lock"
flock 9
"$data/unpack" collision mitch "$work"
flock -u 9

# mean_of REPORT: mean distance from input to decoded, a fraction of the diagonal.
mean_of() {
    sed -nE 's/.*"to_decoded": \{"mean": ([^,]*),.*/\1/p' "$1"
}

# check NAME FRAMES LARGEST_MEAN OPTION...
check() {
    local name=$1 frames=$2 limit=$3 out=$work/$1-$size report=$work/$1-$size.json found
    shift 3
    "$bin/nsdf-enc" "$@" --report "$report" -o "$out.nsdf" "$work/$name"
    "$bin/nsdf-dec" -q --verify "$out.nsdf" >/dev/null
    found=$("$bin/nsdf-dec" -q --resolution 48 -o hash: "$out.nsdf" | wc -l)
    [ "$found" = "$frames" ] || { echo "$name: $found frames came back, not $frames" >&2; exit 1; }
    awk -v m="$(mean_of "$report")" -v limit="$limit" -v name="$name" 'BEGIN {
        printf "%s: mean error %s of the diagonal, at most %s asked for\n", name, m, limit
        exit !(m != "" && m + 0 <= limit + 0) }'
}

if [ "$size" = short ]; then
    check collision 60 5e-3 --preset fast --steps 200 --frame-step 6 --resolution 48
else
    check collision 60 8e-4 --preset fast --resolution 128
    check mitch 10 6e-4 --preset fast --resolution 192
fi

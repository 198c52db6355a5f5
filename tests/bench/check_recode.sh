#!/usr/bin/env bash
# Checks that bench_recode keeps a file's surface when it keeps its integers, and that fewer bits take fewer bytes.
# usage: check_recode.sh BENCH_RECODE BIN_FOLDER FILE.nsdf WORK_FOLDER
set -euo pipefail

usage='usage: check_recode.sh BENCH_RECODE BIN_FOLDER FILE.nsdf WORK_FOLDER'
recode=${1:?$usage}
bin=${2:?$usage}
file=${3:?$usage}
work=${4:?$usage}
mkdir -p "$work"

hashes() {
    "$bin/nsdf-dec" -q --times 0,0.5 --resolution 24 -o hash: "$1"
}

same=$("$recode" "$file" "$work/same.nsdf" range)
plain=$("$recode" "$file" "$work/plain.nsdf" none)
fine=$("$recode" "$file" "$work/fine.nsdf" range 14)
coarse=$("$recode" "$file" "$work/coarse.nsdf" range 9)
for name in same plain fine coarse; do
    "$bin/nsdf-dec" -q --verify "$work/$name.nsdf"
done
integers=$("$recode" "$file" "$work/integers" integers 8)
longer=$("$recode" "$file" "$work/integers-14" integers 14)
before=$(hashes "$file")
after=$(hashes "$work/same.nsdf")
uncoded=$(hashes "$work/plain.nsdf")
rough=$(hashes "$work/coarse.nsdf")
[ -n "$before" ]
[ "$after" = "$before" ]
[ "$uncoded" = "$before" ]
[ "$rough" != "$before" ]
[ "$same" -eq "$(wc -c <"$work/same.nsdf")" ]
[ "$same" -lt "$plain" ]
[ "$coarse" -lt "$fine" ]
[ "$integers" -eq "$(wc -c <"$work/integers")" ]
[ "$integers" -lt "$longer" ]

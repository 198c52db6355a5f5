#!/usr/bin/env bash
# Checks meshes of captured sequences, encoded anew: see tests/tools/check_surfaces.c.  The sequences are not part of
# the project: without them the test is skipped (77).
# usage: real_surfaces.sh BUILD_FOLDER WORK_FOLDER DATA_FOLDER
set -euo pipefail

usage='usage: real_surfaces.sh BUILD_FOLDER WORK_FOLDER DATA_FOLDER'
build=$(cd "${1:?$usage}" && pwd)
work=${2:?$usage}
data=${3:?$usage}

if [ ! -x "$data/unpack" ] || ! command -v zstd >/dev/null; then
    echo "no sequences in $data, or no zstd to unpack them"
    exit 77
fi
if [ "${NSDF_TEST_REAL:-0}" != 1 ]; then
    echo "set NSDF_TEST_REAL=1 to run this test"
    exit 77
fi
mkdir -p "$work"
exec 9>"$work/lock"
flock 9
"$data/unpack" samba gears collision "$work"
flock -u 9

for name in samba gears collision; do
    out=$work/$name-surfaces.nsdf
    "$build/bin/nsdf-enc" -q --preset fast -o "$out" "$work/$name"
    "$build/tests/check_surfaces" "$out" 128 1
    "$build/tests/check_surfaces" "$out" 256 1 0
done

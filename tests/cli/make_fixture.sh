#!/usr/bin/env bash
# Makes what the cases and the hostile-input test need: a small sequence, a tiny file, and broken inputs.
# usage: make_fixture.sh BIN_FOLDER FIXTURE_FOLDER
set -euo pipefail

bin=$(cd "${1:?usage: make_fixture.sh BIN_FOLDER FIXTURE_FOLDER}" && pwd)
out=${2:?usage: make_fixture.sh BIN_FOLDER FIXTURE_FOLDER}
rm -rf "$out"
mkdir -p "$out/bad" "$out/empty"

"$bin/nsdf-sample" metaballs --frames 6 --resolution 24 --fps 24 -q -o "$out/frames"

# Range-coded, and without a coder: other bytes for the parser to meet.
tiny=(--layers 2 --width 16 --steps 60 --batch-points 256 --samples 4000 --resolution 24 --threads 2 -q --fps 24)
"$bin/nsdf-enc" "${tiny[@]}" -o "$out/tiny.nsdf" "$out/frames"
"$bin/nsdf-enc" "${tiny[@]}" --entropy none --weight-bits 6 --width 8 --no-verify -o "$out/plain.nsdf" "$out/frames"

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >"$out/bad/no_faces.obj"
printf 'v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n' >"$out/bad/nan.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n' >"$out/bad/index.obj"

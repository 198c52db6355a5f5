#!/usr/bin/env bash
# Draws docs/figures/walker.png: a frame of the input, the same frame decoded, and a moment between two frames; and
# docs/figures/player.png and heatmap.png, what nsdf-play shows.
# usage: make-figures.sh [BIN_FOLDER]        default: build/bin; takes about two minutes
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
case ${1:-} in
-h | --help)
    sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
bin=$(cd "${1:-$root/build/bin}" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
frames=48 fps=24 shown=14

"$bin/nsdf-sample" walker --frames "$frames" --fps "$fps" --resolution 96 -o "$work/input"
"$bin/nsdf-enc" --preset fast --fps "$fps" -o "$work/walker.nsdf" "$work/input"
# At twice the frame rate, frame 2 i is frame i of the input, and frame 2 i + 1 was never in it.
"$bin/nsdf-dec" -q --fps "$((2 * fps))" --frames "$((2 * shown)),$((2 * shown + 1))" -o "$work/decoded_%04d.obj" \
    "$work/walker.nsdf"
printf -v input_frame '%s/input/walker_%04d.obj' "$work" "$shown"
mkdir -p "$root/docs/figures"
"$bin/nsdf-render" --size 360 --turn 55 --colours c8c2b8,9fb8d0,a9c9a4 -o "$root/docs/figures/walker.png" \
    "$input_frame" "$work"/decoded_*.obj
"$bin/nsdf-play" -q --size 960x400 --times 0.52 --camera 35,8 --overlay --offscreen "$root/docs/figures/player.png" \
    "$root/samples/walker.nsdf"
"$bin/nsdf-play" -q --size 960x400 --frames "$shown" --camera 35,8 --compare "$work/input" --heatmap \
    --heatmap-max 2e-3 --offscreen "$root/docs/figures/heatmap.png" "$root/samples/walker.nsdf"

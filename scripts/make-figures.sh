#!/usr/bin/env bash
# Draws the pictures of README.md and docs/ that show surfaces, with nsdf-play and from samples/walker.nsdf.
# usage: make-figures.sh [BIN_FOLDER]        default: build/bin, which has its tests beside it
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
case ${1:-} in
-h | --help)
    sed -n '2,3s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
bin=$(cd "${1:-$root/build/bin}" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
frames=48 fps=24 shown=14

# The frames that samples/walker.nsdf was made of (samples/README.md).
"$bin/nsdf-sample" walker --frames "$frames" --fps "$fps" --resolution 64 -o "$work/input"
mkdir -p "$root/docs/figures"
# The input's frame and the same decoded; and half a frame later, where the input has nothing.
"$bin/nsdf-play" -q --size 760x400 --frames "$shown" --camera 35,8 --compare "$work/input" \
    --offscreen "$root/docs/figures/walker.png" "$root/samples/walker.nsdf"
between=$(awk -v frame="$shown" -v fps="$fps" 'BEGIN { print (frame + 0.5) / fps }')
"$bin/nsdf-play" -q --size 380x400 --times "$between" --camera 35,8 \
    --offscreen "$root/docs/figures/between.png" "$root/samples/walker.nsdf"
# The blocks take the place of every frame of the input, so that the player draws them.
time=$(awk -v frame="$shown" -v fps="$fps" 'BEGIN { print frame / fps }')
"$bin/../tests/draw_blocks" "$root/samples/walker.nsdf" "$time" "$work/blocks.obj" 0.36
mkdir "$work/blocks"
for ((i = 0; i < frames; i++)); do
    ln -s "$work/blocks.obj" "$(printf '%s/blocks/%02d.obj' "$work" "$i")"
done
"$bin/nsdf-play" -q --size 760x400 --frames "$shown" --camera 35,8 --no-overlay --compare "$work/blocks" \
    --offscreen "$root/docs/figures/blocks.png" "$root/samples/walker.nsdf"
"$bin/nsdf-play" -q --size 960x400 --times 0.52 --camera 35,8 --overlay --offscreen "$root/docs/figures/player.png" \
    "$root/samples/walker.nsdf"
"$bin/nsdf-play" -q --size 960x400 --frames "$shown" --camera 35,8 --compare "$work/input" --heatmap \
    --heatmap-max 2e-3 --offscreen "$root/docs/figures/heatmap.png" "$root/samples/walker.nsdf"

#!/usr/bin/env bash
# Shows what NSDF does: makes a moving surface, compresses it, plays it back at twice its frame rate, draws a picture.
# usage: demo.sh [OUTPUT_FOLDER]        default: demo-output beside this checkout's README
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
case ${1:-} in
-h | --help)
    sed -n '2,3s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
out=${1:-$root/demo-output}
mkdir -p "$out"
out=$(cd "$out" && pwd)
build=$root/build
frames=40 fps=24

say() {
    printf '\n== %s\n' "$*"
}

say "1. Packages"
bash "$root/scripts/install-deps.sh"

say "2. Build (in $build)"
jobs=$(nproc)
if [ ! -f "$build/CMakeCache.txt" ]; then
    generator=()
    command -v ninja >/dev/null && generator=(-G Ninja)
    cmake -S "$root" -B "$build" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release >"$out/build.log" 2>&1 ||
        { tail -n 30 "$out/build.log"; exit 1; }
fi
cmake --build "$build" --parallel "$jobs" --target nsdf-sample nsdf-enc nsdf-dec nsdf-render >>"$out/build.log" 2>&1 ||
    { tail -n 30 "$out/build.log"; exit 1; }
bin=$build/bin
echo "nsdf-sample, nsdf-enc, nsdf-dec and nsdf-render are in $bin"

say "3. A moving surface to compress: a figure that walks, $frames frames at $fps frames per second"
rm -rf "$out/input" "$out/decoded"
"$bin/nsdf-sample" walker --frames "$frames" --fps "$fps" --resolution 96 -o "$out/input"

say "4. Compress it: nsdf-enc fits blocks that move with the surface to all frames (half a minute)"
"$bin/nsdf-enc" --preset fast --fps "$fps" --report "$out/report.json" -o "$out/walker.nsdf" "$out/input"

say "5. Play it back at $((2 * fps)) frames per second: every second frame was never in the input"
mkdir -p "$out/decoded"
"$bin/nsdf-dec" --fps "$((2 * fps))" --resolution 128 -o "$out/decoded/walker_%04d.obj" "$out/walker.nsdf"

say "6. Draw an input frame, the same frame decoded, and the frame in between this one and the next"
middle=$((frames / 4))
printf -v input_frame '%s/input/walker_%04d.obj' "$out" "$middle"
printf -v same_frame '%s/decoded/walker_%04d.obj' "$out" "$((2 * middle))"
printf -v between_frame '%s/decoded/walker_%04d.obj' "$out" "$((2 * middle + 1))"
"$bin/nsdf-render" --size 560 --turn 55 --colours c8c2b8,9fb8d0,a9c9a4 -o "$out/walker.png" \
    "$input_frame" "$same_frame" "$between_frame"

# Sizes in bytes of all files of a folder with an ending.
folder_size() {
    find "$1" -name "$2" -printf '%s\n' | awk '{ sum += $1 } END { printf "%d", sum }'
}

input_bytes=$(folder_size "$out/input" '*.obj')
coded_bytes=$(stat -c %s "$out/walker.nsdf")
frames_out=$(find "$out/decoded" -name '*.obj' | wc -l)
# Both in the encoder's report: a mean distance as a fraction of the diagonal, and the diagonal in metres.
error=$(sed -nE 's/.*"to_decoded": \{"mean": ([^,]*),.*/\1/p' "$out/report.json")
diagonal=$(sed -nE 's/.*"diagonal": ([^,}]*).*/\1/p' "$out/report.json")

say "What you have now"
awk -v i="$input_bytes" -v c="$coded_bytes" -v n="$frames" -v m="$frames_out" \
    -v e="$error" -v d="$diagonal" 'BEGIN {
    printf "  input     %d OBJ frames, %.1f MB; vertices and triangles differ from frame to frame\n", n, i / 1e6
    printf "  walker.nsdf  %.1f KB for all of them: 1/%.0f of the size of the OBJ files\n", c / 1e3, i / c
    if (e != "") printf "  error     %.1f mm on average for a height of 1.75 m (%.2g of the diagonal)\n",
        1000 * e * d, e
    printf "  decoded   %d OBJ frames: the %d of the input, and one between each two of them\n", m, n
}'
cat <<EOF
  picture   left: input, middle: the same frame decoded, right: a frame that was never in the input

Look at
  $out/walker.png          the picture
  $out/walker.nsdf         the compressed surface
  $out/decoded/            the decoded frames, for any program that opens OBJ
  $out/report.json         what the encoder measured

Try next
  $bin/nsdf-play $out/walker.nsdf --speed 1/8        (needs a display)
  $bin/nsdf-play $out/walker.nsdf --offscreen walker_%02d.png --fps 24
  $bin/nsdf-dec --info $out/walker.nsdf
  $bin/nsdf-dec --times 0.5 --resolution 256 -o fine.obj $out/walker.nsdf
  $bin/nsdf-enc --preset medium --fps $fps -o better.nsdf $out/input
  $bin/nsdf-sample --help       other moving surfaces
EOF

#!/usr/bin/env bash
# Checks glTF files of nsdf-dec and of make_gltf with the Khronos validator, compares how nsdf-enc and three.js read
# their animations, and plays one with three.js in Chromium.
# usage: check_gltf.sh BIN_FOLDER FILE.nsdf WORK_FOLDER TOOLS_FOLDER
# Needs node, npm with its registry, and for the last part Chromium (install-deps.sh --gltf); skipped without.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$1 file=$2 work=$3 tools=$4
for program in node npm; do
    command -v "$program" >/dev/null || { echo "$program is not installed"; exit 77; }
done
mkdir -p "$work"
if [ ! -d "$work/node_modules/gltf-validator" ] || [ ! -d "$work/node_modules/three" ]; then
    cp "$here/package.json" "$work/"
    npm install --silent --no-audit --no-fund --prefix "$work" || { echo "npm cannot install its packages"; exit 77; }
fi
cp "$here"/*.js "$work/"
cd "$work"
"$bin/nsdf-dec" -q "$file" -o film.glb --resolution 64
"$bin/nsdf-dec" -q "$file" -o smooth.glb --fps 60 --frames 0-20 --resolution 48 --no-normals
"$bin/nsdf-dec" -q "$file" -o one_%02d.glb --frames 0,7
animated=()
for kind in $("$tools/make_gltf"); do
    "$tools/make_gltf" "$kind" "$kind.glb"
    [ "$kind" = still ] || animated+=("$kind.glb")
done
node validate.js film.glb smooth.glb one_00.glb one_01.glb still.glb "${animated[@]}"
node pose.js "$tools/print_frames" film.glb smooth.glb "${animated[@]}"

browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$browser" ]; then
    echo "no browser: not played"
    exit 0
fi
node play.js film.glb "$browser" .

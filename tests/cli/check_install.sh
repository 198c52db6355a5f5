#!/usr/bin/env bash
# Installs the build into a temporary prefix and builds samples/frame_at.c against it with pkg-config, shared and
# static.
# usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf
set -euo pipefail

root=${1:?usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf}
build=${2:?usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf}
file=${3:?usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

lines=$(wc -l <"$root/samples/frame_at.c")
[ "$lines" -le 40 ] || { echo "frame_at.c has $lines lines; it should fit into 40" >&2; exit 1; }

prefix=$work/prefix
cmake --install "$build" --prefix "$prefix" >"$work/install.log" || { cat "$work/install.log"; exit 1; }
for installed in include/nsdf/decoder.h bin/nsdf-dec bin/nsdf-enc bin/nsdf-cmp share/man/man1/nsdf-dec.1 \
    share/man/man1/nsdf-cmp.1 share/man/man1/nsdf-enc.1 share/man/man3/nsdf.3; do
    [ -f "$prefix/$installed" ] || { echo "$installed was not installed" >&2; exit 1; }
done
if [ -f "$build/bin/nsdf-play" ]; then
    for installed in bin/nsdf-play share/man/man1/nsdf-play.1; do
        [ -f "$prefix/$installed" ] || { echo "$installed was not installed" >&2; exit 1; }
    done
fi
pc=$(find "$prefix" -name nsdf.pc)
[ -n "$pc" ] || { echo "nsdf.pc was not installed" >&2; exit 1; }
PKG_CONFIG_PATH=$(dirname "$pc")
export PKG_CONFIG_PATH
lib=$(pkg-config --variable=libdir nsdf)
[ -f "$lib/libnsdf.so" ] || { echo "nsdf.pc says libdir is $lib, but libnsdf.so is not there" >&2; exit 1; }

# frame_at NAME COMPILER_ARGUMENT...: builds the program; then its output must name a surface.
frame_at() {
    local name=$1 answer
    shift
    "${CC:-cc}" "$root/samples/frame_at.c" -o "$work/$name" "$@"
    answer=$(LD_LIBRARY_PATH=$lib "$work/$name" "$file")
    [[ $answer =~ ^[1-9][0-9]*\ vertices,\ [1-9][0-9]*\ triangles$ ]] || { echo "$name: $answer" >&2; exit 1; }
    echo "$name: $answer"
}

# pkg-config's answer is a list of words.
read -ra shared < <(pkg-config --cflags --libs nsdf)
frame_at shared "${shared[@]}"
# The whole answer first: grep -q would leave ldd writing to a closed pipe, which pipefail takes for a failure.
needs=$(ldd "$work/shared")
[[ $needs == *libnsdf.so* ]] || { echo "the shared build does not use libnsdf.so" >&2; exit 1; }

rm -f "$lib"/libnsdf.so*
read -ra static < <(pkg-config --static --cflags --libs nsdf)
frame_at static "${static[@]}"
needs=$(ldd "$work/static")
if [[ $needs == *libnsdf.so* ]]; then
    echo "the static build uses libnsdf.so" >&2
    exit 1
fi

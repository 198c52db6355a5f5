#!/usr/bin/env bash
# Installs the build into a temporary prefix and builds the example programs of samples/ against it: with pkg-config,
# shared and static, with CMake's find_package, and the library from its sources with one command.
# usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf
set -euo pipefail

root=$(cd "${1:?usage: check_install.sh SOURCE_ROOT BUILD_FOLDER FILE.nsdf}" && pwd)
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

# The other examples: a line for each frame, and the distance of a point far outside.
for example in play_loop query_points; do
    "${CC:-cc}" "$root/samples/$example.c" -o "$work/$example" "${shared[@]}"
done
frames=$("$build/bin/nsdf-dec" --info "$file" | sed -nE 's/^frames *([0-9]+).*/\1/p')
line='^[0-9.]+ s: resolution [0-9]+, [1-9][0-9]* triangles$'
played=$(LD_LIBRARY_PATH=$lib "$work/play_loop" "$file" | grep -cE "$line")
[ -n "$frames" ] && [ "$played" = "$frames" ] || { echo "play_loop: $played frames, not $frames" >&2; exit 1; }
answers=$(printf '0 1e3 0 0\n0.1 0 0 -1e3\n' | LD_LIBRARY_PATH=$lib "$work/query_points" "$file")
awk 'NR == 1 { good += $1 > 900 && $2 > 0.99 } NR == 2 { good += $1 > 900 && $4 < -0.99 } END { exit good != 2 }' \
    <<<"$answers" || { echo "query_points: $answers" >&2; exit 1; }

# The shared library's name carries the version of its interface.
soname=$(objdump -p "$lib/libnsdf.so" | awk '$1 == "SONAME" { print $2 }')
[[ $soname =~ ^libnsdf\.so\.[0-9]+$ && -e $lib/$soname ]] || { echo "the soname is \"$soname\"" >&2; exit 1; }

# find_package, both targets.
mkdir "$work/package"
cat >"$work/package/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(consumer LANGUAGES C)
find_package(nsdf 0.1 REQUIRED)
foreach(kind nsdf shared)
  add_executable(frame_at_${kind} "${EXAMPLE}")
  target_link_libraries(frame_at_${kind} PRIVATE nsdf::${kind})
endforeach()
END
{ cmake -S "$work/package" -B "$work/package/build" -DCMAKE_PREFIX_PATH="$prefix" \
    -DEXAMPLE="$root/samples/frame_at.c" &&
    cmake --build "$work/package/build"; } >"$work/package/log" 2>&1 || { cat "$work/package/log" >&2; exit 1; }
for kind in nsdf shared; do
    answer=$("$work/package/build/frame_at_$kind" "$file")
    [[ $answer =~ ^[1-9][0-9]*\ vertices ]] || { echo "find_package, $kind: $answer" >&2; exit 1; }
    echo "find_package, $kind: $answer"
done

# One command, no configuration, no library but libc's: the sources of the decoder and of the reading half of format/.
readers=()
for reader in "$root"/format/*.c; do
    case ${reader##*/} in
    *_write.c | buffer.c | quantise.c) ;;
    *) readers+=("$reader") ;;
    esac
done
"${CC:-cc}" -O2 "$root/samples/frame_at.c" "$root"/decoder/*.c "${readers[@]}" -I"$root/decoder" \
    -I"$root/decoder/include" -I"$root/format" -lm -pthread -o "$work/bare"
answer=$("$work/bare" "$file")
[[ $answer =~ ^[1-9][0-9]*\ vertices ]] || { echo "one command: $answer" >&2; exit 1; }
echo "one command: $answer"
if needs=$(ldd "$work/bare" | grep -vE 'libc\.|libm\.|linux-vdso|ld-linux|libpthread|libasan|libubsan|libtsan'); then
    echo "one command: needs $needs" >&2
    exit 1
fi
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

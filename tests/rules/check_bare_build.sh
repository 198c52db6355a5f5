#!/usr/bin/env bash
# The decoder must build with a bare `cc -c`: no configuration, no definitions, no library but libc.  The public headers
# must stand alone as C99, C11 and C++17.
# usage: check_bare_build.sh SOURCE_ROOT
set -euo pipefail

cd "${1:?usage: check_bare_build.sh SOURCE_ROOT}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
    printf '%s\n' "$*" >&2
    failures=$((failures + 1))
}

# The reader half is what format/CMakeLists.txt puts into nsdf_format_read.
readers=$(tr '\n' ' ' <format/CMakeLists.txt |
    sed -nE 's/.*target_sources\(nsdf_format_read PRIVATE ([^)]*)\).*/\1/p')
[ -n "$readers" ] || fail "format/CMakeLists.txt: no sources of nsdf_format_read found"
sources=(decoder/*.c decoder/export/*.c)
for reader in $readers; do
    sources+=("format/$reader")
done

compilers=()
for compiler in "${CC:-cc}" gcc clang; do
    if command -v "$compiler" >/dev/null; then
        path=$(readlink -f "$(command -v "$compiler")")
        [[ " ${compilers[*]:-} " == *" $path "* ]] || compilers+=("$path")
    fi
done
for compiler in "${compilers[@]}"; do
    for source in "${sources[@]}"; do
        "$compiler" -O1 -Wall -Werror -Iformat -Idecoder -Idecoder/include -c "$source" -o "$work/object.o" ||
            fail "$compiler cannot build $source without configuration"
    done
    echo "${compiler##*/}: ${#sources[@]} decoder sources"
    for header in decoder/include/nsdf/*.h encoder/include/nsdf/*.h; do
        for standard in c99 c11; do
            "$compiler" "-std=$standard" -Wall -Wextra -Wpedantic -Werror -Idecoder/include -Iencoder/include \
                -fsyntax-only -x c - <<<"#include \"${header#*/include/}\"" ||
                fail "$header does not stand alone as $standard"
        done
    done
done
if command -v c++ >/dev/null; then
    for header in decoder/include/nsdf/*.h encoder/include/nsdf/*.h; do
        c++ -std=c++17 -Wall -Wextra -Wpedantic -Werror -Idecoder/include -Iencoder/include -fsyntax-only -x c++ - \
            <<<"#include \"${header#*/include/}\"" || fail "$header does not stand alone as C++17"
    done
else
    echo "no C++ compiler: headers not checked as C++"
fi
[ "$failures" -eq 0 ]

#!/usr/bin/env bash
# Builds the decoder for 64-bit ARM with Debian's cross compiler, and runs its tests in QEMU: the kernels against plain
# C, the golden files, the reference decoder, meshes; and decodes the sample with the vectors of ARM and without them.
# usage: run.sh SOURCE_FOLDER BUILD_FOLDER      exit code 77 = cannot be run here (scripts/install-deps.sh --arm)
set -euo pipefail
source=$(cd "$1" && pwd)
build=$2
for tool in aarch64-linux-gnu-gcc qemu-aarch64 cmake ninja; do
    command -v "$tool" >/dev/null || { echo "needs $tool" && exit 77; }
done
[ -e /usr/lib/aarch64-linux-gnu/pkgconfig/cmocka.pc ] || { echo "needs cmocka for arm64" && exit 77; }
tests=(test_net_kernels test_blocks_decoder test_golden test_reference test_decoder_api test_decoder_mesh test_mesher
    test_entropy test_compose)
cmake -S "$source" -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$source/cmake/aarch64-linux-gnu.cmake" \
    -DNSDF_WERROR=ON -DNSDF_MPI=OFF -DNSDF_BUILD_PLAYER=OFF -DNSDF_WITH_ZLIB=OFF -DNSDF_WITH_ZSTD=OFF \
    >"$build.log" 2>&1 || { cat "$build.log" && exit 1; }
cmake --build "$build" --target nsdf-dec "${tests[@]}" >"$build.log" 2>&1 || { tail -n 40 "$build.log" && exit 1; }
export QEMU_LD_PREFIX=/ NSDF_TEST_EMULATED=1
for test in "${tests[@]}"; do
    qemu-aarch64 "$build/tests/$test" >"$build.log" 2>&1 || { echo "FAILED: $test" && cat "$build.log" && exit 1; }
    echo "$test: $(grep -c '\[       OK \]' "$build.log") tests"
done
decode() {
    qemu-aarch64 "$build/bin/nsdf-dec" "$source/samples/walker.nsdf" --frames 7 --resolution 64 --threads 1 "$@"
}
kernels=$(qemu-aarch64 "$build/bin/nsdf-dec" --info "$source/samples/walker.nsdf" | awk '$1 == "kernels" { print $2 }')
[ "$kernels" = neon ] || { echo "FAILED: the kernels are '$kernels'" && exit 1; }
# Blocks have one kernel here, so that the mask changes nothing.
[ "$(decode -o hash:)" = "$(decode --cpu-mask c -o hash:)" ] || { echo "FAILED: the mask changes the mesh" && exit 1; }
echo "the sample decodes"

#!/usr/bin/env bash
# Installs what the build and the tests need, on Debian and its relatives; says what is needed elsewhere.
# usage: install-deps.sh [--clang] [--bench] [--meshlab] [--gltf] [--https] [--arm]
#   --clang     also the second compiler, for scripts/test.sh --all
#   --bench     also what the programs in tests/bench compare with and draw with
#   --meshlab   also what the test compare_meshlab compares with
#   --gltf      also what the test gltf_elsewhere plays glTF files with
#   --https     also the server of the test cli_dec_https
#   --arm       also what the test arm builds and runs the decoder for 64-bit ARM with
set -euo pipefail

packages=(gcc g++ libc6-dev cmake ninja-build pkg-config zlib1g-dev libzstd-dev libcmocka-dev zstd
          libgl-dev libglfw3-dev libosmesa6-dev libpng-dev libstb-dev xvfb xdotool libtinygltf-dev assimp-utils
          libopenmpi-dev openmpi-bin libcurl4-openssl-dev)
for option in "$@"; do
    case $option in
    --clang) packages+=(clang) ;;
    --meshlab) packages+=(meshlab xvfb xauth) ;;
    --gltf)
        packages+=(chromium)
        # npm from elsewhere and Debian's exclude each other
        command -v npm >/dev/null || packages+=(nodejs npm)
        ;;
    --https) packages+=(nginx-light openssl) ;;
    --arm) packages+=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user libcmocka-dev:arm64) ;;
    --bench) packages+=(draco libdraco-dev libopenblas-dev gnuplot-nox) ;;
    *)
        echo "install-deps: unknown option: $option" >&2
        exit 2
        ;;
    esac
done

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "install-deps: this is not Debian; please make sure that these are installed:"
    echo "  a C11 compiler, CMake 3.25, Ninja or make, pkg-config, zlib, zstd, cmocka"
    echo "  for URLs: libcurl 7.85; nginx and openssl for one of its tests"
    echo "  for nsdf-play: GLFW 3.3, OSMesa, libpng, stb, OpenGL headers; for its tests Xvfb and xdotool"
    echo "  for glTF files: a C++ compiler and tinygltf; assimp for its tests"
    echo "  for encoding on many machines: OpenMPI"
    echo "  for tests/bench: a C++17 compiler, Draco, OpenBLAS, gnuplot"
    exit 0
fi

missing=()
for package in "${packages[@]}"; do
    # Debian 12 has pkg-config as a name of pkgconf
    if [ "$package" = pkg-config ] && command -v pkg-config >/dev/null; then
        continue
    fi
    # A package may be there for several architectures: a line for each.
    dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
if [ "${#missing[@]}" -eq 0 ]; then
    echo "install-deps: everything is installed"
    exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "install-deps: missing packages, and neither root nor sudo to install them. As root, run:" >&2
        echo "  apt-get install ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi

# Mirrors fail now and then: three tries, with a pause.
apt() {
    local try
    for try in 1 2 3; do
        if "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
            apt-get -o Acquire::Retries=3 -o DPkg::Lock::Timeout=120 "$@"; then
            return 0
        fi
        echo "install-deps: apt-get $1 failed (try $try of 3)" >&2
        sleep $((try * 5))
    done
    return 1
}

if [[ " ${missing[*]} " == *:arm64* ]]; then
    "${as_root[@]}" dpkg --add-architecture arm64
fi
echo "install-deps: installing ${missing[*]}"
apt -qq update
apt -qq -y install --no-install-recommends "${missing[@]}" >/dev/null
echo "install-deps: done"

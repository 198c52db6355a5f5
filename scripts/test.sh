#!/usr/bin/env bash
# Builds NSDF and runs its tests; the last line is "N passed, N failed".
# usage: test.sh [--quick | --all]
#   (default)  quick tests of an optimised build, then unit and hostile-input tests under the address and
#              undefined-behaviour sanitizers
#   --quick    the first stage only
#   --all      also the tests labelled long and real, a build with clang, and the thread sanitizer
# Environment: NSDF_TEST_REAL=1 runs the tests labelled real; NSDF_TEST_BUILD is the folder to build in (build-test);
# NSDF_TEST_SKIP_INSTALL=1 leaves packages alone.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mode=default
case ${1:-} in
'') ;;
--quick) mode=quick ;;
--all) mode=all ;;
-h | --help)
    sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
*)
    echo "test.sh: unknown option: $1 (--help lists the options)" >&2
    exit 2
    ;;
esac

base=${NSDF_TEST_BUILD:-$root/build-test}
jobs=$(nproc)
passed=0 failed=0
log=$base/ctest.log

say() {
    printf '\n== %s (%d s)\n' "$*" "$SECONDS"
}

# Configures and builds a folder below $base; a failure counts as one failed test.
build() {
    local name=$1
    shift
    local folder=$base/$name generator=()
    if [ ! -f "$folder/CMakeCache.txt" ] && command -v ninja >/dev/null; then
        generator=(-G Ninja)
    fi
    mkdir -p "$folder"
    if cmake -S "$root" -B "$folder" "${generator[@]}" -DNSDF_WERROR=ON "$@" >"$folder/build.log" 2>&1 &&
        cmake --build "$folder" --parallel "$jobs" >>"$folder/build.log" 2>&1; then
        return 0
    fi
    tail -n 60 "$folder/build.log"
    echo "test.sh: the build in $folder failed; all of its output is in build.log there"
    failed=$((failed + 1))
    return 1
}

# Runs ctest in a build folder and adds up its result.
run() {
    local folder=$base/$1 total bad
    shift
    ctest --test-dir "$folder" --output-on-failure --no-tests=error --timeout 300 -j "$jobs" "$@" 2>&1 |
        tee "$log" || true
    total=$(sed -nE 's/.* tests? failed out of ([0-9]+).*/\1/p' "$log" | tail -n 1)
    bad=$(sed -nE 's/.*tests passed, ([0-9]+) tests? failed.*/\1/p' "$log" | tail -n 1)
    if [ -z "$total" ]; then
        failed=$((failed + 1))
        return
    fi
    passed=$((passed + total - bad))
    failed=$((failed + bad))
}

if [ "${NSDF_TEST_SKIP_INSTALL:-0}" != 1 ]; then
    say "Packages"
    if [ "$mode" = all ]; then
        bash "$root/scripts/install-deps.sh" --clang --gltf --https
    else
        bash "$root/scripts/install-deps.sh"
    fi
fi
mkdir -p "$base"

labels=quick
if [ "$mode" = all ]; then
    labels='quick|long|real'
elif [ "${NSDF_TEST_REAL:-0}" = 1 ]; then
    labels='quick|real'
fi

say "Optimised build"
if build release -DCMAKE_BUILD_TYPE=Release; then
    say "Tests: $labels"
    NSDF_TEST_REAL=$([ "$labels" = quick ] && echo 0 || echo 1) run release -L "^($labels)\$"
fi

if [ "$mode" != quick ]; then
    say "Build with address and undefined-behaviour sanitizers"
    if build sanitize -DCMAKE_BUILD_TYPE=RelWithDebInfo -DNSDF_SANITIZE=address,undefined; then
        say "Unit and hostile-input tests under the sanitizers"
        run sanitize -L '^quick$' -R '^(test_|hostile_|fuzz_replay_|cli_fixture)'
    fi
fi

if [ "$mode" = all ]; then
    say "Build with clang"
    if build clang -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++; then
        run clang -L '^quick$'
    fi
    say "Build with the thread sanitizer"
    if build thread -DCMAKE_BUILD_TYPE=RelWithDebInfo -DNSDF_SANITIZE=thread; then
        run thread -L '^quick$' -R '^(test_|cli_fixture)'
    fi
fi

say "Done"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

#!/usr/bin/env bash
# Builds the fuzz targets with clang, libFuzzer and the sanitizers, and runs each for some time; prints what each did.
# Inputs that fail are kept in BUILD_FOLDER/findings/TARGET: mended, they belong into tests/fuzz/findings/TARGET.
# usage: run_fuzz.sh SOURCE_ROOT BUILD_FOLDER SECONDS_PER_TARGET [TARGET...]
set -euo pipefail

usage='usage: run_fuzz.sh SOURCE_ROOT BUILD_FOLDER SECONDS_PER_TARGET [TARGET...]'
root=$(cd "${1:?$usage}" && pwd)
build=${2:?$usage}
seconds=${3:?$usage}
shift 3
targets=("$@")
[ "${#targets[@]}" -gt 0 ] || targets=(probe evaluate mesh callbacks entropy round_trip)

if ! command -v clang >/dev/null; then
    echo "no clang: the fuzz targets cannot be built"
    exit 77
fi
mkdir -p "$build"
if ! { cmake -S "$root" -B "$build" -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=RelWithDebInfo -DNSDF_FUZZ=ON \
    -DNSDF_SANITIZE=address,undefined,fuzzer-no-link -DNSDF_BUILD_PLAYER=OFF &&
    cmake --build "$build" --parallel 2 --target fuzz_corpus "${targets[@]/#/fuzz_}"; } >"$build/build.log" 2>&1; then
    tail -n 40 "$build/build.log" >&2
    exit 1
fi

failures=0
for target in "${targets[@]}"; do
    case $target in
    entropy | round_trip) seeds=$build/tests/fuzz/seeds/arrays longest=1024 ;;
    *) seeds=$build/tests/fuzz/seeds/files longest=24576 ;;
    esac
    corpus=$build/corpus/$target findings=$build/findings/$target log=$build/$target.log
    mkdir -p "$corpus" "$findings"
    "$build/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -max_len="$longest" -timeout=20 -rss_limit_mb=1024 \
        -dict="$root/tests/fuzz/nsdf.dict" -artifact_prefix="$findings/" -print_final_stats=1 "$corpus" "$seeds" \
        >"$log" 2>&1 || {
        echo "$target: a finding, see $log" >&2
        grep -E 'ERROR|SUMMARY|runtime error|Test unit written' "$log" >&2 || true
        failures=$((failures + 1))
        continue
    }
    awk -v target="$target" '
        / cov: / { for (i = 1; i < NF; i++) if ($i == "cov:") edges = $(i + 1) }
        /stat::number_of_executed_units/ { runs = $2 }
        /^INFO: Loaded 1 modules/ { all = $5; gsub(/[^0-9]/, "", all) }
        END { printf "%s: %d executions, %d of %s edges\n", target, runs, edges, all }' "$log"
done
[ "$failures" -eq 0 ]

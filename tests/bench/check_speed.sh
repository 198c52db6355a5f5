#!/usr/bin/env bash
# Checks that the speed bench works and prints all of its rows; its figures mean nothing here.
# usage: check_speed.sh BIN_FOLDER WORK_FOLDER
set -euo pipefail
export LC_ALL=C

usage='usage: check_speed.sh BIN_FOLDER WORK_FOLDER'
bin=${1:?$usage}
work=${2:?$usage}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
failures=0

fail() {
    printf '%s\n' "$*" >&2
    failures=$((failures + 1))
}

rm -rf "$work"
"$here/speed" --tiny --model network --bin "$bin" --out "$work" --csv "$work/speed.csv" --json "$work/speed.json" \
    >"$work.txt"

# expect SECTION MEASURE UNIT THREADS...: for each count of threads one row, with positive numbers (seconds may be
# rounded to 0).  MEASURE is a pattern.
expect() {
    local section=$1 measure=$2 unit=$3 threads
    shift 3
    for threads in "$@"; do
        awk -F, -v section="$section" -v measure="^$measure\$" -v unit="$unit" -v threads="$threads" '
            $1 == section && $2 ~ measure && $3 == threads && $6 == unit {
                found += ($4 > 0 || unit == "s") && $5 != ""
            }
            END { exit found != 1 }' "$work/speed.csv" ||
            fail "not one row: $section, $measure, $threads threads, $unit"
    done
}

# expect_ratio SECTION MEASURE UNIT COLUMN THREADS...: the row has a number in that column, which may be empty.
expect_ratio() {
    local section=$1 measure=$2 unit=$3 column=$4 threads
    shift 4
    for threads in "$@"; do
        awk -F, -v section="$section" -v measure="^$measure\$" -v unit="$unit" -v threads="$threads" \
            -v column="$column" '
            NR == 1 { for (i = 1; i <= NF; i++) if ($i == column) at = i }
            $1 == section && $2 ~ measure && $3 == threads && $6 == unit && at && $at > 0 { found = 1 }
            END { exit !found }' "$work/speed.csv" ||
            fail "no $column: $section, $measure, $threads threads, $unit"
    done
}

# The rows of both kinds of meshes at a resolution.
expect_draco() {
    local coding
    expect draco "at $1: size" vertices 1
    expect draco "at $1: NSDF" ms/frame 1
    expect draco "at $1: NSDF with normals" us/vertex 1
    for coding in '-cl 7 -qp 11' '-cl 10 -qp 11' '-cl 10 -qp 12' '-cl 7 -qp 11 -qn 8' '-cl 10 -qp 12 -qn 10'; do
        expect_ratio draco "at $1: Draco $coding" us/vertex of_draco 1
    done
}

has() {
    ! grep -q "\"$1\": \"not built in\"" "$work/speed.json"
}

best=$(sed -nE 's/.*"fastest instruction set": "([^"]*)".*/\1/p' "$work/speed.json")
[ -n "$best" ] || fail "speed.json does not name the instruction set"
grep -q '"two threads": "[0-9.]* x one' "$work/speed.json" || fail "speed.json does not tell what two threads gain"

for rule in pseudo-normal winding; do
    expect sdf "$rule: build" ms 1
    for place in 'within 0.002' 'within 0.02' 'in the box'; do
        expect sdf "$rule: $place" samples/s 1 2
    done
done
expect fit "register loop $best" GFLOP/s 1 2
fitting=$best # with bf16, where the processor is faster with it
for factors in bf16 amx; do
    grep -q "$best-$factors" "$work/speed.csv" && fitting=$best-$factors
done
for width in 32 64 80 128 256; do
    expect fit "fitting 3 x $width .*$fitting" GFLOP/s 1 2
    expect fit "fitting 3 x $width .*$fitting" samples/s 1 2
    expect_ratio fit "fitting 3 x $width .*$fitting" GFLOP/s of_fma 1 2
    expect_ratio fit "fitting 3 x $width .*$fitting" GFLOP/s cpu 1
    expect fit "kernel: multiply $width wide" GFLOP/s 1
    expect fit "kernel: multiply transposed $width wide" GFLOP/s 1
    expect fit "kernel: outer product $width wide" GFLOP/s 1
done
for stage in sample fit code verify; do
    expect encode "nsdf-enc: $stage" "$([ "$stage" = fit ] && echo samples/s || echo s)" 2
done
expect_ratio encode 'nsdf-enc: fit' GFLOP/s of_fma 2
expect decode 'open and close' ms 1 2
expect decode 'open to first frame' ms 1 2
for resolution in 16 32; do
    expect decode "frame at $resolution" ms/frame 1 2
    expect decode "frame at $resolution: values" points 1
    expect decode "frame at $resolution: gradients" points 1
    expect memory "frame at $resolution" MB 1 2
done
for what in value gradient; do
    expect decode "nsdf_evaluate: $what $best" Mpoints/s 1 2
    expect_ratio decode "nsdf_evaluate: $what $best" GFLOP/s of_fma 1 2
done
if has OpenBLAS; then
    expect fit 'OpenBLAS sgemm 64' GFLOP/s 1 2
    expect_ratio fit "fitting 3 x 80 $fitting" GFLOP/s of_sgemm 1 2
fi
if has Draco; then
    for resolution in 16 32; do
        expect_draco "$resolution"
    done
    expect draco 'original frame: Draco' us/vertex 1
fi

rows=$(($(wc -l <"$work/speed.csv") - 1))
[ "$(grep -c '"section"' "$work/speed.json")" = "$rows" ] || fail "speed.json has not the $rows rows of speed.csv"
grep -q "^frame at 32 " "$work.txt" || fail "the table has no frames"

# Blocks: what depends on the model, without operations, which nobody knows of them.
"$bin/bench_speed" --tiny --sections decode,draco "$here/../../samples/walker.nsdf" | grep -v "^# " >"$work/speed.csv"
expect decode 'frame at 32' ms/frame 1 2
expect decode 'frame at 32: values' points 1
expect decode "nsdf_evaluate: gradient $best" Mpoints/s 1 2
! grep -q 'nsdf_evaluate.*GFLOP' "$work/speed.csv" || fail 'operations of blocks are not known'
! has Draco || expect_draco 32
"$here/speed" --tiny --model spheres >/dev/null 2>&1 && fail 'a model that does not exist was taken'
echo "$rows rows; $failures failures"
[ "$failures" -eq 0 ]

#!/usr/bin/env bash
# Runs tests/bench/thesis at its smallest scale on a generated sequence, and checks what it leaves.
# usage: check_thesis.sh BIN_FOLDER
set -euo pipefail
export LC_ALL=C

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$(cd "${1:?usage: check_thesis.sh BIN_FOLDER}" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
out=$work/out results=$work/out/results
mkdir "$work/none"

give_up() {
    printf 'FAILED: %s\n' "$*" >&2
    [ ! -f "$work/log" ] || tail -n 20 "$work/log" >&2
    exit 1
}

# No folder of sequences: the script makes its own.
bench() {
    bash "$here/thesis" --scale tiny --data "$work/none" --out "$out" --bin "$bin" "$@" >"$work/log" 2>&1
}

# Prints the values of a column in the rows of a result that fit a pattern.
column() {
    awk -F, -v name="$2" -v pattern="${3:-.}" '
        NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i; next }
        $0 ~ pattern { print $at }' "$results/$1.csv"
}

# rows NAME COUNT: the result has so many rows, and no empty cell.
rows() {
    local file=$results/$1.csv
    [ -f "$file" ] || give_up "there is no $1.csv"
    [ "$(($(wc -l <"$file") - 1))" = "$2" ] || give_up "$1.csv has not $2 rows: $(<"$file")"
    awk -F, '
        NR == 1 { n = NF }
        { for (i = 1; i <= n; i++) if ($i == "") bad = 1 }
        NF != n { bad = 1 }
        END { exit bad }' "$file" || give_up "$1.csv has empty cells: $(<"$file")"
}

bench || give_up "the script ended with $?"
rows table8.1 6
rows table8.2 4
rows table8.3 6
rows table8.4 6
rows figure8.1 2
rows figure8.2 5
rows figure8.3 5
if command -v gnuplot >/dev/null; then
    for chart in figure8.{1,2,3}.{svg,png}; do
        [ -s "$results/$chart" ] || give_up "there is no $chart"
    done
fi

# The size of the input: 12 bytes for each vertex and each triangle of the five frames from the middle of nine.
input=0
for frame in 2 3 4 5 6; do
    input=$((input + 12 * $(grep -c '^[vf] ' "$out/data/wave-box/wave-box_000$frame.obj")))
done
[ "$(column table8.2 input_bytes | sort -u)" = "$input" ] || give_up "the input has not $input bytes"
run=$out/runs/$(column figure8.2 run q8-zip)
size=$(stat -c %s "$run/q8-zip.nsdf")
awk -v a="$input" -v b="$size" -v c="$(column figure8.2 ratio q8-zip)" \
    'BEGIN { exit !(sprintf("%.3f", a / b) == c) }' || give_up "the ratio of q8-zip is wrong"
cmp -s "$run/q8.nsdf" "$run/q8-zip.nsdf" && give_up "q8 and q8-zip are one coding"

# The maxima and averages are those that nsdf-cmp states for the same comparison.
"$bin/nsdf-cmp" -q --units world --measures fmpd --resolution 16 --json -o "$work/all.json" \
    "$out/lists/wave-box.full.txt" "$run/q8.nsdf"
stated() {
    sed -nE "s/^ *\"$1\": ([^,]*),?\$/\\1/p" "$work/all.json"
}
for pair in hausdorff_max=hausdorff_max hausdorff_avg=hausdorff_mean fmpd_max=fmpd_max fmpd_avg=fmpd_mean; do
    awk -v a="$(column figure8.2 "${pair%=*}" ',q8,')" -v b="$(stated "${pair#*=}")" \
        'BEGIN { exit !(a != "" && b > 0 && (a - b) ^ 2 <= 1e-8 * (1 + b * b)) }' || give_up "${pair%=*} of q8 is wrong"
done
# Even and odd frames make up all of them.
all=$(column table8.1 compared ',half,.*,all,') even=$(column table8.1 compared ',half,.*,even,')
odd=$(column table8.1 compared ',half,.*,odd,')
[ "$all/$even/$odd" = 5/3/2 ] || give_up "compared: $all frames, $even even ones, $odd odd ones"
# The frame that is interpolated was not fitted, and is the one that is measured.
for side in 1 2 3; do
    gap=$out/runs/$(column table8.3 run "gap4-$side,.*,fourier,")
    grep -q "\"frames\": $((2 * side))," "$gap/report.json" || give_up "gap4-$side: not $((2 * side)) frames fitted"
    [ "$(cut -d, -f1 "$gap/float32-r16.csv" | tr '\n' ' ')" = "frame $side " ] || give_up "gap4-$side: another frame"
    sed -n "$((side + 1))p" "$out/lists/wave-box.gap4-$side.txt" | grep -q '_0004.obj$' || give_up "not frame 4"
done

# What is there is not run again; what has other options is, and so is what is not complete.
bench || give_up "the second run ended with $?"
grep -q ' 0 of 12 fits' "$work/log" || give_up "the second run repeats fits"
rm "$run/q8-r16.csv" && touch -d yesterday "$run/float32.nsdf"
bench --only figure8.2 || give_up "a run of figure 8.2 ended with $?"
grep -q ' 1 of 1 fits' "$work/log" || give_up "a comparison that is missing is not made"
[ -n "$(find "$run/float32.nsdf" -mmin +60)" ] || give_up "a comparison that is missing repeats the fit"
cat >"$work/mine.sh" <<'EOF'
loss_options() {
    echo --loss "$1" --delta 0.02
}
define_experiments() {
    experiment mine sampler='near rejection' loss='mae surface'
}
EOF
bench --experiments "$work/mine.sh" || give_up "an experiment of one's own ended with $?"
rows mine 4

# Every table of the page is written, and nothing else changes.
cp "$here/../../docs/thesis.md" "$work/page.md"
bench --doc "$work/page.md" && give_up "tables from the results of another experiment"
bench || give_up "the last run ended with $?"
bench --doc "$work/page.md" || give_up "--doc ended with $?"
outside() {
    awk '/^<!-- end -->/ { inside = 0 } !inside { print } /^<!-- thesis / { inside = 1 }' "$1"
}
[ "$(outside "$work/page.md")" = "$(outside "$here/../../docs/thesis.md")" ] || give_up "--doc changes the text"
awk '/^<!-- thesis / { name = $3; lines = 0; next } /^\|/ { lines++ }
    /^<!-- end -->/ { if (lines < 3 || !name) { print "no table " name; bad = 1 } name = ""; n++ }
    END { exit bad || n < 9 }' "$work/page.md" || give_up "--doc left tables out"

# A frame without surface is a result, which is left out and not measured again.
mkdir "$work/bin"
ln -s "$bin/nsdf-enc" "$bin/nsdf-sample" "$work/bin"
printf '#!/bin/sh\necho "nsdf-cmp: float32.nsdf, frame 1: no faces" >&2\nexit 1\n' >"$work/bin/nsdf-cmp"
chmod +x "$work/bin/nsdf-cmp"
nothing=(--bin "$work/bin" --out "$work/empty" --only table8.2)
bench "${nothing[@]}" || give_up "frames without surface ended with $?"
[ "$(grep -c 'no surface at some frame' "$work/log")" = 4 ] || give_up "frames without surface are not told"
bench "${nothing[@]}" || give_up "frames without surface ended with $? the second time"
grep -q ' 0 of 4 fits' "$work/log" || give_up "frames without surface are measured again"
sed -i 's/no faces/out of memory/' "$work/bin/nsdf-cmp"
rm "$work"/empty/runs/*/*.empty
bench "${nothing[@]}" && give_up "a comparison that fails otherwise counts as one"

usage() {
    local code=0
    bench "$@" || code=$?
    [ "$code" = 2 ] || give_up "$*: exit code $code, not 2"
}
usage --scale enormous
usage --only table9.9
usage --frobnicate
usage --out
bench --list || give_up "--list ended with $?"
[ "$(grep -c ' done ' "$work/log")" = 34 ] || give_up "--list does not list what is done"
echo "all experiments at the smallest scale: tables, charts and page are complete"

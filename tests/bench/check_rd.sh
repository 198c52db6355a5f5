#!/usr/bin/env bash
# Runs the rate-distortion bench on a tiny sequence: rows, chart, summary, and that a second run repeats nothing.
# usage: check_rd.sh BIN_FOLDER FIXTURE_FOLDER       the fixture of the command-line tests; its folder frames is used
# Exit code 77 when rd_draco was not built or gnuplot is not installed.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$(cd "${1:?usage: check_rd.sh BIN_FOLDER FIXTURE_FOLDER}" && pwd)
fixture=$(cd "${2:?usage: check_rd.sh BIN_FOLDER FIXTURE_FOLDER}" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ ! -x "$bin/rd_draco" ] || ! command -v gnuplot >/dev/null; then
    echo "needs libdraco-dev and gnuplot-nox (scripts/install-deps.sh --bench)"
    exit 77
fi

give_up() {
    printf 'FAILED: %s\n' "$*" >&2
    cat "$work/log" >&2
    exit 1
}

# bench STEPS OPTION...: a run whose second NSDF setting takes this many steps, decoded at `resolution`.
resolution=32
bench() {
    cat >"$work/settings.sh" <<END
resolution=$resolution
settings_full() {
    tiny="--layers 2 --batch-points 256 --samples 4000 --resolution 24"
    setting nsdf small \$tiny --width 8 --steps 200
    setting nsdf large \$tiny --width 16 --steps $1
    for keep in 20 50 100; do
        setting draco k\$keep --keep \$keep --qp 8
    done
}
END
    shift
    "$here/rd" --bin "$bin" --settings "$work/settings.sh" --out "$work/out" --data "$fixture" --sequences frames "$@" \
        >"$work/stdout" 2>"$work/log" || give_up "rd $* failed"
}

# Points that the last run measured.
measured() {
    grep -c '^rd: [0-9]* of [0-9]*: ' "$work/log" || true
}

bench 300
[ "$(measured)" = 5 ] || give_up "$(measured) points were measured, not 5"
rows=$(awk -F, 'NR > 1 && $1 == "frames" && $4 == 6 && $5 > 100 && $6 * 6 > $5 - 1 && $9 > 1e-5 && $9 < 0.5 &&
    $12 > 0 && $14 > 0 && $15 == 6 { n[$2]++ } END { print NR, n["nsdf"], n["draco"] }' "$work/out/results.csv")
[ "$rows" = '6 2 3' ] || give_up "results.csv: $(cat "$work/out/results.csv")"
# Draco keeps every triangle there; what 8 bits a coordinate leave is below a cell of 1/255.
awk -F, '$3 == "k100" && $9 < 1 / 255 { found = 1 } END { exit !found }' "$work/out/results.csv" ||
    give_up "Draco's error is too large: $(cat "$work/out/results.csv")"
grep -q '^frames ' "$work/stdout" || give_up "no summary: $(cat "$work/stdout")"
for title in NSDF 'Draco after decimation'; do
    # gnuplot names each curve; what is drawn follows.
    grep -A4 "<title>$title</title>" "$work/out/rd.svg" | grep -q '<path' || give_up "rd.svg draws no hull of $title"
done
head -c 8 "$work/out/rd.png" | cmp -s - <(printf '\211PNG\r\n\032\n') || give_up "rd.png is not a PNG picture"

cp "$work/out/results.csv" "$work/first.csv"
bench 300
[ "$(measured)" = 0 ] || give_up "a second run measured $(measured) points again"
cmp -s "$work/first.csv" "$work/out/results.csv" || give_up "a second run changed the results"
bench 310
[ "$(measured)" = 1 ] || give_up "$(measured) points were measured after one option changed"
bench 310 --codecs draco --force
[ "$(measured)" = 3 ] || give_up "--codecs draco --force measured $(measured) points, not 3"
[ "$(wc -l <"$work/out/results.csv")" = 6 ] || give_up "the points of the other codec are gone"
resolution=24
bench 310
[ "$(measured)" = 2 ] || give_up "$(measured) points were measured at another resolution, not those of NSDF"
echo "points, chart and second runs are right"

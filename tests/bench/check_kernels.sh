#!/usr/bin/env bash
# Checks that the bench of kernels works and prints all of its rows; its figures mean nothing here.
# usage: check_kernels.sh BIN_FOLDER
set -euo pipefail
export LC_ALL=C

bin=${1:?usage: check_kernels.sh BIN_FOLDER}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
failures=0
rows=$("$here/kernels" --tiny --csv --bin "$bin")

# expect SECTION KERNEL: for plain C, which is everywhere, one row with a positive rate and share.
expect() {
    awk -F, -v section="$1" -v kernel="$2" '
        $1 == section && $2 == kernel && $3 == "c" { found += $4 > 0 && $6 > 0 }
        END { exit found != 1 }' <<<"$rows" || {
        echo "not one row: $1, $2" >&2
        failures=$((failures + 1))
    }
}

grep -q '^peak,register loop,c,[0-9.]*,GFLOP/s' <<<"$rows" || failures=$((failures + 1))
for level in first-level second-level; do
    grep -q "^peak,$level cache,[a-z0-9]*,[0-9.e+]*,GB/s" <<<"$rows" || failures=$((failures + 1))
done
expect fit '3 x 64: all passes'
for pass in 'all passes' find forward backward; do
    expect blocks "$pass"
done
for what in 'network 3 x 64' blocks; do
    expect decode "$what: value"
    expect decode "$what: with gradient"
done
echo "$failures failures"
[ "$failures" -eq 0 ]

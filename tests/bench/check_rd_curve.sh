#!/usr/bin/env bash
# Checks the arithmetic of the rate-distortion bench on curves whose differences were worked out by hand.
# usage: check_rd_curve.sh
set -euo pipefail
export LC_ALL=C

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# curves SEQUENCE NSDF DRACO: points "bytes:dB:error ..."; error is 1 where it does not matter.
curves() {
    local codec=nsdf points point bytes psnr mean
    for points in "$2" "$3"; do
        for point in $points; do
            IFS=: read -r bytes psnr mean <<<"$point"
            echo "$1,$codec,$bytes,$psnr,$mean"
        done
        codec=draco
    done
}

{
    echo sequence,codec,bytes_per_frame,psnr_d2,mean
    curves same '1000:60:1 4000:70:1' '1000:60:1 4000:70:1'
    curves half '500:60:1 2000:70:1' '1000:60:1 4000:70:1'
    # Base-2 logarithms of the bytes, NSDF's minus Draco's: 0 at 60 dB, 1 at 70, on average 1/2; 2^(1/2) = 1.414.
    curves fan '1000:60:1 4000:70:1' '1000:60:1 2000:70:1'
    # -1 at 60 dB, 1 at 70.
    curves cross '1000:60:1 8000:70:1' '2000:60:1 4000:70:1'
    # 0 at 60 dB, 1/2 at 65, 0 at 70, on average 1/4; 2^(1/4) = 1.189.
    curves knot '1000:60:1 8000:70:1' '8000:70:1 2000:65:1 1000:60:1'
    # Equal hulls: 65 dB is above the line, 58 dB is worse and larger, 70 dB is there twice, one point has no error.
    curves hull '3000:65:1 1000:60:1 4000:70:1 1500:58:1 5000:70:1 9000:inf:0' '1000:60:1 4000:70:1'
    # At 65 dB NSDF needs 2000 bytes, Draco 4000; both grow alike.
    curves part '1000:60:1 4000:70:1' '4000:65:1 16000:75:1'
    curves apart '1000:60:1 4000:70:1' '4000:71:1 16000:75:1'
    curves alone '1000:60:1 4000:70:1' ''
    # Four times the bytes for a quarter of the error: twice for half of it, halfway in logarithms.
    curves sizes '1000:60:1e-3 4000:70:2.5e-4' '4000:60:1e-3 12000:66:3e-4'
} >"$work/results.csv"
awk -v folder="$work" -f "$here/rd_curve.awk" -f "$here/rd_report.awk" "$work/results.csv" >"$work/report"
tr -s ' ' <"$work/report" >"$work/words"

expect() {
    if ! grep -qxF -- "$1" "$work/words"; then
        echo "not found: $1"
        failures=$((failures + 1))
    fi
}

expect 'same +0.0 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'half -50.0 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'fan +41.4 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'cross +0.0 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'knot +18.9 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'hull +0.0 % 60.0 to 70.0 dB 60.0 to 70.0 dB 60.0 to 70.0 dB'
expect 'part -50.0 % 65.0 to 70.0 dB 60.0 to 70.0 dB 65.0 to 75.0 dB'
expect 'apart - nothing shared 60.0 to 70.0 dB 71.0 to 75.0 dB'
expect 'alone - nothing shared 60.0 to 70.0 dB no point'
expect 'sizes 1e-3 1000 4000 0.250'
# Draco: 4000 * 3^(ln 2 / ln (10/3)) = 7529.
expect ' 5e-4 2000 7529 0.266'
expect ' 2.5e-4 4000 - -'
diff "$work/hull.nsdf.psnr" <(printf '%s\n' bytes_per_frame,psnr 1000,60 4000,70) || failures=$((failures + 1))
diff "$work/sizes.nsdf.mean" <(printf '%s\n' bytes_per_frame,mean 1000,0.001 4000,0.00025) || failures=$((failures + 1))

if [ "$failures" -gt 0 ]; then
    cat "$work/report"
    exit 1
fi
echo "all differences as worked out by hand"

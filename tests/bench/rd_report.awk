# Reads results.csv of the rate-distortion bench; prints Bjontegaard differences and sizes at fixed errors, and writes
# the hulls for the chart.
# usage: awk -v folder=FOLDER -f rd_curve.awk -f rd_report.awk results.csv
#   FOLDER gets SEQUENCE.CODEC.psnr and SEQUENCE.CODEC.mean: the points of the hull over either axis, as CSV

BEGIN {
    FS = ","
    error_count = split("1e-3 5e-4 2.5e-4", errors, " ")
}

NR == 1 {
    for (i = 1; i <= NF; i++)
        column[$i] = i
    next
}

{
    sequence = $column["sequence"]
    codec = $column["codec"]
    if (!(sequence in known)) {
        known[sequence] = 1
        sequences[++sequence_count] = sequence
    }
    bytes = $column["bytes_per_frame"] + 0
    psnr = $column["psnr_d2"]
    mean = $column["mean"] + 0
    # An infinite PSNR (no error at all) has no place on a curve.
    if (bytes <= 0 || psnr !~ /^-?[0-9]/ || mean <= 0)
        next
    i = ++count[sequence, codec]
    y[sequence, codec, i] = log(bytes)
    x[sequence, codec, "psnr", i] = psnr + 0
    x[sequence, codec, "mean", i] = -log(mean)
}

# Hull of a sequence's codec; axis is "psnr" or "mean".
function make_hull(sequence, codec, axis, hx, hy,    i, n, px, py) {
    n = count[sequence, codec] + 0
    for (i = 1; i <= n; i++) {
        px[i] = x[sequence, codec, axis, i]
        py[i] = y[sequence, codec, i]
    }
    return curve_hull(px, py, n, hx, hy)
}

function write_hull(sequence, codec, axis,    i, n, hx, hy, file) {
    n = make_hull(sequence, codec, axis, hx, hy)
    file = folder "/" sequence "." codec "." axis
    print "bytes_per_frame," axis >file
    for (i = 1; i <= n; i++)
        printf "%.9g,%.9g\n", exp(hy[i]), axis == "mean" ? exp(-hx[i]) : hx[i] >file
    close(file)
}

function range_text(hx, m) {
    return m ? sprintf("%.1f to %.1f dB", hx[1], hx[m]) : "no point"
}

function print_difference(sequence,    ax, ay, an, bx, by, bn, low, high, mean) {
    an = make_hull(sequence, "nsdf", "psnr", ax, ay)
    bn = make_hull(sequence, "draco", "psnr", bx, by)
    if (an && bn) {
        low = ax[1] > bx[1] ? ax[1] : bx[1]
        high = ax[an] < bx[bn] ? ax[an] : bx[bn]
    }
    if (an && bn && low < high) {
        mean = curve_mean_difference(ax, ay, an, bx, by, bn, low, high)
        printf "%-12s %+7.1f %%  %-17s", sequence, 100 * (exp(mean) - 1), sprintf("%.1f to %.1f dB", low, high)
    } else {
        printf "%-12s %9s  %-17s", sequence, "-", "nothing shared"
    }
    printf "  %-17s  %s\n", range_text(ax, an), range_text(bx, bn)
}

# Bytes per frame of a codec's hull at a mean error; 0 when the hull does not reach from one side of it to the other.
function bytes_at(sequence, codec, error,    hx, hy, m, at) {
    m = make_hull(sequence, codec, "mean", hx, hy)
    at = -log(error)
    return m && at >= hx[1] && at <= hx[m] ? exp(curve_at(hx, hy, m, at)) : 0
}

function print_sizes(sequence,    i, nsdf, draco) {
    for (i = 1; i <= error_count; i++) {
        nsdf = bytes_at(sequence, "nsdf", errors[i])
        draco = bytes_at(sequence, "draco", errors[i])
        printf "%-12s %8s  %8s  %8s  %10s\n", i == 1 ? sequence : "", errors[i], nsdf ? sprintf("%.0f", nsdf) : "-",
            draco ? sprintf("%.0f", draco) : "-", nsdf && draco ? sprintf("%.3f", nsdf / draco) : "-"
    }
}

END {
    print "Bytes of NSDF against Draco at equal PSNR: mean difference over the shared range (Bjontegaard), between"
    print "lower convex hulls in (dB, log bytes), linear between their points. Negative: NSDF needs fewer."
    printf "%-12s %9s  %-17s  %-17s  %s\n", "sequence", "BD-rate", "shared range", "NSDF", "Draco"
    for (s = 1; s <= sequence_count; s++)
        print_difference(sequences[s])
    print ""
    print "Bytes per frame at a mean error (fraction of the diagonal; linear between hull points in log and log);"
    print "-: the hull does not reach there."
    printf "%-12s %8s  %8s  %8s  %10s\n", "sequence", "error", "NSDF", "Draco", "NSDF/Draco"
    for (s = 1; s <= sequence_count; s++)
        print_sizes(sequences[s])
    for (s = 1; s <= sequence_count; s++) {
        write_hull(sequences[s], "nsdf", "psnr")
        write_hull(sequences[s], "nsdf", "mean")
        write_hull(sequences[s], "draco", "psnr")
        write_hull(sequences[s], "draco", "mean")
    }
}

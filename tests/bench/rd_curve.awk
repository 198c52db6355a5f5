# Rate-distortion curves, functions for rd_report.awk: hulls, values between their points, mean differences.
# A curve is a list of points (x, y): x grows with quality (PSNR in dB, or minus the logarithm of an error), y is the
# logarithm of the bytes.  Names after the extra space are local.

# Lower convex hull of n points: what the best settings reach, and mixtures of them.  It begins at the point of fewest
# bytes, since what is worse and larger than that is of no use, and ends at the best quality.  Fills hx, hy from 1 and
# returns how many.
function curve_hull(x, y, n, hx, hy,    i, k, order, first, m) {
    if (n == 0)
        return 0
    for (i = 1; i <= n; i++) {
        for (k = i; k > 1 && curve_before(x, y, i, order[k - 1]); k--)
            order[k] = order[k - 1]
        order[k] = i
    }
    first = 1
    for (i = 2; i <= n; i++)
        if (y[order[i]] <= y[order[first]])
            first = i
    m = 0
    for (i = first; i <= n; i++) {
        k = order[i]
        # Of points of one quality, the first has the fewest bytes.
        if (m > 0 && x[k] == hx[m])
            continue
        while (m > 1 && (hy[m] - hy[m - 1]) * (x[k] - hx[m - 1]) >= (y[k] - hy[m - 1]) * (hx[m] - hx[m - 1]))
            m--
        m++
        hx[m] = x[k]
        hy[m] = y[k]
    }
    return m
}

# Order by quality, then by bytes.
function curve_before(x, y, a, b) {
    return x[a] < x[b] || (x[a] == x[b] && y[a] < y[b])
}

# Linear between the points of a hull; x must lie within it.
function curve_at(hx, hy, m, x,    i) {
    if (m == 1)
        return hy[1]
    for (i = 2; i < m && hx[i] < x; i++)
        ;
    return hy[i - 1] + (hy[i] - hy[i - 1]) * (x - hx[i - 1]) / (hx[i] - hx[i - 1])
}

# Mean of a - b over [low, high], which must lie within both hulls: exact, since the difference is linear between
# neighbouring points of either.
function curve_mean_difference(ax, ay, an, bx, by, bn, low, high,    i, sum, x, next_x, difference, next_difference) {
    x = low
    difference = curve_at(ax, ay, an, x) - curve_at(bx, by, bn, x)
    sum = 0
    while (x < high) {
        next_x = high
        for (i = 1; i <= an; i++)
            if (ax[i] > x && ax[i] < next_x)
                next_x = ax[i]
        for (i = 1; i <= bn; i++)
            if (bx[i] > x && bx[i] < next_x)
                next_x = bx[i]
        next_difference = curve_at(ax, ay, an, next_x) - curve_at(bx, by, bn, next_x)
        sum += 0.5 * (difference + next_difference) * (next_x - x)
        x = next_x
        difference = next_difference
    }
    return sum / (high - low)
}

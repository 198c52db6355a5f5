# Draws a chart of tests/bench/thesis.
# usage: gnuplot -e 'results="figure8.1.csv"; chart="figure8.1.svg"; kind="svg"; name="figure8.1"' thesis_plot.gp
#   figure8.1: average FMPD over samples of a frame; other names: over the compression ratio, without and with ZIP
if (kind eq "svg") {
    set terminal svg size 640,420 font "Helvetica,13" background "white"
} else {
    set terminal pngcairo size 640,420 font "Helvetica,11" background "white"
}
set output chart
set datafile separator ","
set datafile columnheaders
set datafile missing NaN
set style line 1 linecolor rgb "#1f5fa8" linewidth 2 pointtype 7 pointsize 0.7
set style line 2 linecolor rgb "#d9822b" linewidth 2 pointtype 5 pointsize 0.7
set grid linecolor rgb "#dddddd"
set ylabel "average FMPD"
set yrange [0:*]
set logscale x
zipped(c) = strlen(c) > 4 && c[strlen(c) - 3:] eq "-zip"
label(c) = c eq "float32" ? "32" : c[2:]

if (name eq "figure8.1") {
    set xlabel "samples of a frame"
    sources = system("awk -F, 'NR > 1 && !seen[$2]++ { print $2 }' '" . results . "'")
    set key top right
    plot for [i=1:words(sources)] results using "samples":(strcol("source") eq word(sources, i) ? \
        column("fmpd_avg") : NaN) with linespoints linestyle i title word(sources, i) noenhanced
} else {
    set xlabel "compression ratio (numbers: bits a weight)"
    set key top left
    source = system("awk -F, 'NR == 2 { print $2 }' '" . results . "'")
    set title source noenhanced
    plot results using (zipped(strcol("compression")) ? NaN : column("ratio")):"fmpd_avg" with points linestyle 1 \
             title "quantised", \
         "" using (zipped(strcol("compression")) ? NaN : column("ratio")):"fmpd_avg": \
             (label(strcol("compression"))) with labels offset 0,0.8 notitle, \
         "" using (zipped(strcol("compression")) ? column("ratio") : NaN):"fmpd_avg" with points linestyle 2 \
             title "quantised and ZIP"
}

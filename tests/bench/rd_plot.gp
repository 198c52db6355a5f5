# Draws the chart of the rate-distortion bench: a row of two panels for each sequence.
# usage: gnuplot -e 'sequences="samba mitch"; folder="OUT"; points="vdmc_points.csv"; heading="..."; kind="svg"' rd_plot.gp
#   folder holds results.csv and hulls/, and gets rd.svg or, with kind="png", rd.png; points is the file of V-DMC's points
rows = words(sequences)
height = 60 + 330 * rows
if (kind eq "svg") {
    set terminal svg size 1000,height font "Helvetica,13" background "white"
} else {
    set terminal pngcairo size 1000,height font "Helvetica,11" background "white"
}
set output folder . "/rd." . kind
set datafile separator ","
set datafile columnheaders
set datafile missing NaN

set style line 1 linecolor rgb "#1f5fa8" linewidth 2 pointtype 7 pointsize 0.6
set style line 2 linecolor rgb "#d9822b" linewidth 2 pointtype 5 pointsize 0.5
set style line 3 linecolor rgb "#2e8b57" linewidth 1.5 pointtype 9 pointsize 1.1
set style line 4 linecolor rgb "#2e8b57" linewidth 1.5 pointtype 8 pointsize 1.1
set style line 5 linecolor rgb "#8c8c8c" linewidth 1.5 pointtype 1 pointsize 0.9
set grid xtics ytics linetype 1 linewidth 0.5 linecolor rgb "#dddddd"
set autoscale fix
set offsets graph 0.04, graph 0.04, graph 0.04, graph 0.04
set logscale x
set xtics (50, 100, 200, 500, "1k" 1000, "2k" 2000, "5k" 5000, "10k" 10000, "20k" 20000, "50k" 50000, "100k" 100000)

results = folder . "/results.csv"
bytes(codec) = strcol("sequence") eq name && strcol("codec") eq codec ? column("bytes_per_frame") : NaN
other(series) = strcol("sequence") eq name && strcol("series") eq series ? column("bytes_per_frame") : NaN
hull(codec) = sprintf("%s/hulls/%s.%s.%s", folder, name, codec, axis)

set multiplot layout rows,2 title heading
do for [name in sequences] {
    do for [axis in "psnr mean"] {
        set title name noenhanced
        set xlabel "bytes per frame"
        if (axis eq "psnr") {
            unset logscale y
            set ytics auto
            set ylabel "PSNR D2, dB"
            value = "psnr_d2"
            set key bottom right Left reverse samplen 1 spacing 0.9 width -5 font ",8"
        } else {
            set logscale y
            set ytics ("2e-5" 2e-5, "5e-5" 5e-5, "1e-4" 1e-4, "2e-4" 2e-4, "5e-4" 5e-4, "1e-3" 1e-3, "2e-3" 2e-3, \
                       "5e-3" 5e-3, "1e-2" 1e-2, "2e-2" 2e-2, "5e-2" 5e-2)
            set ylabel "mean error / diagonal"
            value = "mean"
            unset key
        }
        plot results using (bytes("draco")):value with points linestyle 2 notitle, \
             hull("draco") using 1:2 with lines linestyle 2 title "Draco after decimation", \
             results using (bytes("nsdf")):value with points linestyle 1 notitle, \
             hull("nsdf") using 1:2 with lines linestyle 1 title "NSDF", \
             points using (other("official")):value with points linestyle 3 title "V-DMC, official, 300 frames", \
             points using (other("inter")):value with points linestyle 4 title "V-DMC, run, inter", \
             points using (other("intra")):value with points linestyle 5 title "V-DMC, run, intra"
    }
}
unset multiplot

# What tests/bench/thesis runs: scales, named components, and experiments made of all combinations of them; loaded by
# the script.  Runs whose options have changed here are made anew.
# shellcheck shell=bash disable=SC2034,SC2154

# ---- Scales -------------------------------------------------------------------------------------------------------
# layers, width, learning_rate   of the network of the thesis
# window        frames of a sequence that are used, from its middle; 0 = all
# steps         of Adam, with 8 frames of 1024 points in each
# gap_steps     the same for interpolating one frame
# samples       of a frame, after rejection; series: those of figure 8.1
# resolution    at which surfaces are extracted for measuring
# bits          of figures 8.2 and 8.3
# gaps          frames that are interpolated in tables 8.3 and 8.4
# generated     sequences of nsdf-sample that stand for the first and the second when they are missing;
#               generated_frames, generated_resolution: how they are made
generated='walker metaballs'

# Seconds: shows that everything works.
scale_tiny() {
    layers=2 width=24 learning_rate=5e-3 window=5 steps=600 gap_steps=200 samples=1000 series='300 1000' resolution=16
    bits='4 8' gaps=4 generated='wave-box wave-box' generated_frames=9 generated_resolution=12
}

# A quarter of an hour on two cores.
scale_small() {
    layers=8 width=64 learning_rate=2e-3 window=33 steps=5000 gap_steps=1500 samples=8000
    series='250 1000 4000 8000 16000' resolution=96 bits='4 5 6 7 8 10 12 16' gaps='25 50 75 100 125'
    generated_frames=140 generated_resolution=48
}

# A night: all frames.
scale_medium() {
    scale_small
    layers=8 width=128 learning_rate=1e-3 window=0 steps=40000 gap_steps=4000 samples=16000
    series='500 2000 8000 16000 32000' resolution=128 generated_resolution=64
}

# The network of the thesis, all frames; days.
scale_full() {
    scale_small
    layers=16 width=256 learning_rate=5e-4 window=0 steps=40000 gap_steps=8000 samples=40000
    series='1000 5000 10000 20000 40000 80000' resolution=192 generated_frames=175 generated_resolution=96
}

# ---- Components ---------------------------------------------------------------------------------------------------
# The options of nsdf-enc that a name stands for; nonzero when there is no such name.

sampler_options() {
    case $1 in
    rejection) echo --sampling rejection --d-half 0.05 ;; # the thesis does not state its d_0.5
    near) echo --sampling near ;;
    *) return 1 ;;
    esac
}

# The thesis has one, and so does the encoder: a box over the whole sequence, divided by its diagonal (5.8, 5.9).
mesh_options() {
    [ "$1" = box ]
}

sdf_options() {
    case $1 in
    unit | diagonal) echo --sdf-norm "$1" ;; # [-1, 1] (5.10), or fractions of the diagonal
    *) return 1 ;;
    esac
}

time_options() {
    case $1 in
    unit | speed) echo --time-norm "$1" ;; # (5.11), (5.13)
    *) return 1 ;;
    esac
}

representation_options() {
    case $1 in
    mlp) echo --input xyzt ;;
    # "For each original feature, five Fourier features were calculated": 20 rows of B, whose elements have the variance
    # 3; their cosines and sines (5.14) are 40 inputs.
    fourier) echo --input fourier --fourier-features 20 --fourier-sigma 1.7320508 ;;
    fourier-trained) echo --input fourier --fourier-features 20 --fourier-sigma 1.7320508 --fourier-trained ;;
    # Not of the thesis: NSDF's own network, of its own size.
    temporal)
        echo --input xyz --weights spline --activation sine --output-activation identity --layers 3 --width 80 \
            --learning-rate 2e-3
        ;;
    *) return 1 ;;
    esac
}

loss_options() {
    case $1 in
    mae | surface | weighted) echo --loss "$1" ;;
    *) return 1 ;;
    esac
}

# Weight bits and entropy coder of nsdf-enc --also: float32, q8 (8 bits, min-max), q8-zip (deflate behind it), q8-range.
compression_options() {
    local bits=${1#q}
    case $1 in
    float32) echo 32,none ;;
    q*-zip) echo "${bits%-zip},deflate" ;;
    q*-range) echo "${bits%-range},range" ;;
    q*) echo "$bits,none" ;;
    *) return 1 ;;
    esac
}

# Frames that are fitted, of `count`: `full` (all of the window), `half` (every second one of them), gap25-2 (two on
# each side of frame 25 of the sequence, and frame 25 is measured).
frames_options() {
    local side
    case $1 in
    full) ;;
    half) echo --frames "0-$((count - 1))/2" ;;
    gap*-*)
        side=${1#*-}
        echo --frames "0-$((side - 1)),$((side + 1))-$((2 * side))"
        ;;
    *) return 1 ;;
    esac
}

# ---- Experiments --------------------------------------------------------------------------------------------------
# experiment NAME KEY='VALUES'...   all combinations; keys that are not given have the values of defaults.  What is
# measured (`measured`) is all frames, the even or the odd ones of those that were compared.

defaults() {
    source=$sources frames=full sampler=rejection mesh=box sdf=unit time=unit representation=mlp loss=mae
    compression=float32 measured=all
}

define_experiments() {
    local pair quantised='' around='' gap side
    for pair in $bits; do
        quantised+=" q$pair q$pair-zip"
    done
    for gap in $gaps; do
        for side in 1 2 3; do
            around+=" gap$gap-$side"
        done
    done
    experiment table8.1 frames='full half' representation=fourier loss=surface measured='all even odd'
    experiment table8.2 representation='mlp fourier' loss='mae surface'
    # The thesis does not say with which features it interpolates.  8.3 is the Hausdorff distance, 8.4 FMPD of these.
    experiment table8.3 frames="$around" representation='mlp fourier' loss=surface
    experiment table8.4 frames="$around" representation='mlp fourier' loss=surface
    experiment figure8.1 samples="$series"
    experiment figure8.2 source="$second" representation=fourier loss=surface compression="float32$quantised"
    experiment figure8.3 source="$first" representation=fourier loss=surface compression="float32$quantised"
}

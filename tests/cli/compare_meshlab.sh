#!/usr/bin/env bash
# Compares the distances that nsdf-cmp measures with those of MeshLab's filter "Hausdorff Distance", on decoded frames
# of captured sequences.  Without MeshLab (scripts/install-deps.sh --meshlab), or without the sequences, the test is
# skipped (77).
# usage: compare_meshlab.sh BIN_FOLDER WORK_FOLDER DATA_FOLDER
set -euo pipefail

usage='usage: compare_meshlab.sh BIN_FOLDER WORK_FOLDER DATA_FOLDER'
bin=$(cd "${1:?$usage}" && pwd)
work=${2:?$usage}
data=${3:?$usage}

for program in meshlabserver xvfb-run xauth zstd "$bin/nsdf-cmp"; do
    if ! command -v "$program" >/dev/null; then
        echo "$program is not there"
        exit 77
    fi
done
if [ ! -x "$data/unpack" ]; then
    echo "no sequences in $data"
    exit 77
fi
mkdir -p "$work"
"$data/unpack" samba gears mitch "$work"

# obj_to_off OBJ: not every OBJ file that is correct can be read by MeshLab.
obj_to_off() {
    awk '$1 == "v" { vertex[vertices++] = $2 " " $3 " " $4 }
        $1 == "f" {
            line = NF - 1
            for (i = 2; i <= NF; i++) {
                split($i, part, "/")
                line = line " " part[1] - 1
            }
            face[faces++] = line
        }
        END {
            print "OFF"
            print vertices, faces, 0
            for (i = 0; i < vertices; i++) print vertex[i]
            for (i = 0; i < faces; i++) print face[i]
        }' "$1"
}

# filter FROM TO SAMPLES VERTICES_TOO: one step of a MeshLab script.
filter() {
    cat <<END
 <filter name="Hausdorff Distance">
  <Param type="RichMesh" name="SampledMesh" value="$1"/>
  <Param type="RichMesh" name="TargetMesh" value="$2"/>
  <Param type="RichBool" name="SaveSample" value="false"/>
  <Param type="RichBool" name="SampleVert" value="$4"/>
  <Param type="RichBool" name="SampleEdge" value="false"/>
  <Param type="RichBool" name="SampleFauxEdge" value="false"/>
  <Param type="RichBool" name="SampleFace" value="true"/>
  <Param type="RichInt" name="SampleNum" value="$3"/>
  <Param type="RichAbsPerc" name="MaxDist" value="1000" min="0" max="1000"/>
 </filter>
END
}

# meshlab_script SAMPLES: MeshLab's mean and RMS are over random points only when vertices are not sampled; its maximum
# needs the vertices.
meshlab_script() {
    echo '<!DOCTYPE FilterScript>'
    echo '<FilterScript>'
    filter 0 1 "$1" false
    filter 1 0 "$1" false
    filter 0 1 "$1" true
    filter 1 0 "$1" true
    echo '</FilterScript>'
}

# meshlab_distances REFERENCE DECODED SAMPLES: mean and RMS to the decoded mesh, the same to the reference, both maxima.
# Every filter prints "min : A   max B   mean : C   RMS : D" in world units first, then in diagonals.
meshlab_distances() {
    meshlab_script "$3" >"$work/hausdorff.mlx"
    xvfb-run -a -s '-screen 0 640x480x24' meshlabserver -i "$1" "$2" -s "$work/hausdorff.mlx" 2>&1 |
        awk '/^LOG.*Hausdorff Distance computed/ { n++; fresh = 1 }
            /^LOG.*min :.*RMS :/ && fresh {
                fresh = 0
                for (i = 1; i < NF; i++) {
                    if ($i == "max") max[n % 2] = $(i + 1) > max[n % 2] ? $(i + 1) : max[n % 2]
                    if ($i == "mean") mean[n] = $(i + 2)
                    if ($i == "RMS") rms[n] = $(i + 2)
                }
            }
            END { if (n == 4) print mean[1], rms[1], mean[2], rms[2], max[1], max[0] }'
}

# our_distances REFERENCE DECODED SAMPLES PEAK: the same, and the PSNR.
our_distances() {
    "$bin/nsdf-cmp" -q --csv --units world --measures distance --samples "$3" --peak "$4" "$1" "$2" |
        awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i }
            NR == 2 {
                print $column["mean_to_dec"], $column["rms_to_dec"], $column["mean_to_ref"], $column["rms_to_ref"],
                    $column["max_to_dec"], $column["max_to_ref"], $column["psnr_d2"]
            }'
}

longest_side() {
    awk '$1 == "v" { for (k = 2; k <= 4; k++) {
            if (!n || $k < low[k]) low[k] = $k
            if (!n || $k > high[k]) high[k] = $k
        } n++ }
        END { for (k = 2; k <= 4; k++) if (high[k] - low[k] > side) side = high[k] - low[k]; print side }' "$1"
}

# report NAME OURS THEIRS PEAK: fails where they differ by more than 2 % (0.1 dB).  Maxima are of a sample each, and may
# differ by more where the worst place is small.
report() {
    awk -v name="$1" -v ours="$2" -v theirs="$3" -v peak="$4" 'BEGIN {
        split("mean_to_dec rms_to_dec mean_to_ref rms_to_ref max_to_dec max_to_ref", label, " ")
        if (split(ours, a, " ") != 7 || split(theirs, b, " ") != 6) {
            print name ": no figures: \"" ours "\", \"" theirs "\""
            exit 1
        }
        for (i = 1; i <= 6; i++) {
            off = 100 * (a[i] / b[i] - 1)
            printf "%-9s %-12s nsdf-cmp %.6f  MeshLab %.6f  %+.2f %%\n", name, label[i], a[i], b[i], off
            limit = i <= 4 ? 2 : 8
            wrong += !(off < limit && off > -limit)
        }
        worse = b[2] > b[4] ? b[2] : b[4]
        psnr = 10 * log(3 * peak * peak / (worse * worse)) / log(10)
        printf "%-9s %-12s nsdf-cmp %.3f dB  MeshLab %.3f dB\n", name, "psnr_d2", a[7], psnr
        wrong += !(a[7] - psnr < 0.1 && psnr - a[7] < 0.1)
        exit wrong > 0
    }'
}

# check NAME FRAME FRAME_STEP SAMPLES: the frame as a short fit of every few frames gives it.
failures=0
check() {
    local name=$1 reference peak ours theirs
    reference=$work/$name/${name}_$(printf %04d "$2").obj
    "$bin/nsdf-enc" -q --preset fast --steps 1500 --frame-step "$3" --resolution 128 -o "$work/$name.nsdf" "$work/$name"
    "$bin/nsdf-dec" -q --frames "$2" -o "$work/$name-decoded.obj" "$work/$name.nsdf"
    obj_to_off "$reference" >"$work/$name.off"
    obj_to_off "$work/$name-decoded.obj" >"$work/$name-decoded.off"
    peak=$(longest_side "$reference")
    ours=$(our_distances "$reference" "$work/$name-decoded.obj" "$4" "$peak")
    theirs=$(meshlab_distances "$work/$name.off" "$work/$name-decoded.off" "$4")
    report "$name $2" "$ours" "$theirs" "$peak" || failures=$((failures + 1))
}

check samba 60 60 200000
check samba 30 60 50000 # between the frames that were fitted: far off
check gears 50 50 1000000
check mitch 5 5 200000
[ "$failures" -eq 0 ]

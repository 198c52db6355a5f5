# Broken meshes are encoded as the clean ones are: the decoded surface is that of the clean mesh.
small=(--layers 2 --width 32 --steps 1000 --batch-points 512 --samples 20000 --resolution 64 --threads 2)
mean_error() { # REF FILE: the larger of both directions, times 1e4, rounded up
    nsdf-cmp "$1" "$2" --measures none --samples 4000 --resolution 96 |
        awk '$1 == "mean" { m = $2 > $3 ? $2 : $3; printf "%d\n", 1e4 * m + 1 }'
}
nsdf-dirty sphere --frames 3 -o clean
for faults in "" "broken" "flip=0.3 duplicate=0.1 sliver=0.1 unused=5 order" "inward remove=0.02"; do
    rm -rf dirty
    # shellcheck disable=SC2086
    nsdf-dirty sphere $faults --each --frames 3 -o dirty
    nsdf-enc "${small[@]}" dirty -o dirty.nsdf 2>messages
    lines=$(grep -c 'the input is not clean' messages) || true
    [ "$lines" = "$([ -n "$faults" ] && echo 1 || echo 0)" ] || give_up "'$faults': $(<messages)"
    error=$(mean_error clean dirty.nsdf)
    [ "$error" -le 60 ] || give_up "'$faults': mean error ${error}e-4 from the clean mesh"
    echo "sphere $faults: mean error below 6e-3"
done

# An open sheet needs no option; half its thickness is in the error.
nsdf-dirty sheet --frames 2 -o sheet
nsdf-enc "${small[@]}" --shell 0.2 sheet -o sheet.nsdf 2>messages
grep -q '1 open sheet given a thickness of 0.2$' messages || give_up "$(<messages)"
error=$(mean_error sheet sheet.nsdf)
[ "$error" -le 400 ] || give_up "sheet: mean error ${error}e-4"
nsdf-enc "${tiny[@]}" sheet -o sheet.nsdf 2>messages
grep -q 'thickness of 0.00[0-9]* (1/300 of the diagonal; --shell T changes it)' messages || give_up "$(<messages)"

# Faults come from a seed.
nsdf-dirty sphere broken --frames 1 -o a
nsdf-dirty sphere broken --frames 1 -o b
same a/dirty_0000.obj b/dirty_0000.obj
nsdf-dirty clean flip=0.5 -o c
[ "$(find c -name '*.obj' | wc -l)" = 3 ] || give_up "a folder of three frames gave others"
fails 2 flip nsdf-dirty sphere flip=2 -o d
fails 2 split nsdf-dirty sphere split=1 -o d
fails 2 no-such nsdf-dirty no-such -o d

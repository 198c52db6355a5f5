# Every back end gives the same parameters, so the same meshes; coded files are smaller than packed ones.
for coder in none deflate zstd range; do
    nsdf-enc -q "${tiny[@]}" --no-verify --entropy "$coder" --weight-bits 8 -o "$coder.nsdf" fixture/frames
    nsdf-dec -q --resolution 16 -o hash: "$coder.nsdf" >"$coder.hash"
    same none.hash "$coder.hash"
done
[ "$(size_of range.nsdf)" -lt "$(size_of none.nsdf)" ] || give_up "the range coder saves nothing"

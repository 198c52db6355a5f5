# The ready sample stays small, whole and full of surface, at its frames and between them.
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
[ "$(size_of "$walker")" -le 40960 ] || give_up "the sample has $(size_of "$walker") bytes"
nsdf-dec --verify "$walker" >verified
grep -q ': ok (48 frames' verified || give_up "not verified: $(<verified)"
nsdf-dec --fps 9 --resolution 64 -q -o walker_%02d.obj "$walker"
for mesh in walker_*.obj; do
    faces=$(grep -c '^f ' "$mesh") || give_up "$mesh is empty"
    [ "$faces" -gt 1000 ] || give_up "$mesh has only $faces triangles"
done
find . -name "walker_*.obj" | wc -l

nsdf-dec --frames 1 --resolution 24 -q -o f.obj fixture/tiny.nsdf
nsdf-dec --frames 1 --resolution 24 -q -o f.ply fixture/tiny.nsdf
nsdf-dec --frames 1 --resolution 24 -q -o f.stl fixture/tiny.nsdf
vertices=$(grep -c '^v ' f.obj) triangles=$(grep -c '^f ' f.obj)
[ "$triangles" -gt 0 ] || give_up "no triangles"
grep -aq "element vertex $vertices" f.ply || give_up "PLY has other vertices than OBJ"
grep -aq "element face $triangles" f.ply || give_up "PLY has other faces than OBJ"
[ "$(size_of f.stl)" = $((84 + 50 * triangles)) ] || give_up "STL has another number of triangles than OBJ"
# Closed genus-any surfaces of c pieces: F = 2 V - 2 X, so F is even.
[ $((triangles % 2)) = 0 ] || give_up "an odd number of triangles cannot be closed"
echo "three formats agree"
nsdf-dec --frames 1 --resolution 24 -q --format stl -o - fixture/tiny.nsdf | cmp - f.stl
echo "stdout is the same"

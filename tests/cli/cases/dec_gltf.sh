answer=$(nsdf-dec -o /dev/null --format glb fixture/tiny.nsdf --frames 0 2>&1)
[[ $answer != *"without tinygltf"* ]] || skip "no glTF in this build"
nsdf-dec -q fixture/tiny.nsdf -o one.glb --frames 1 --resolution 24
nsdf-dec -q fixture/tiny.nsdf -o all.glb --resolution 24
nsdf-dec -q fixture/tiny.nsdf -o p_%02d.glb --frames 1,2 --resolution 24
nsdf-dec -q fixture/tiny.nsdf -o - --format glb --resolution 24 >stream.glb
same one.glb p_00.glb
same all.glb stream.glb
nsdf-dec -q fixture/tiny.nsdf -o bare.glb --frames 1 --resolution 24 --no-normals

# The container: magic, version 2, its own length; a description in JSON, then bytes; both of whole words.
word() { od -An -tu4 -j "$2" -N 4 "$1" | tr -d ' '; }
for file in one.glb all.glb bare.glb; do
    [ "$(head -c 4 $file)" = glTF ] && [ "$(word $file 4)" = 2 ] && [ "$(word $file 8)" = "$(size_of $file)" ] ||
        give_up "$file: not glTF 2"
    json=$(word $file 12)
    [ $((json % 4)) = 0 ] && [ $(($(word $file $((20 + json))) + json + 28)) = "$(size_of $file)" ] ||
        give_up "$file: chunks"
    head -c $((20 + json)) $file | tail -c "$json" >$file.json
done
grep -q NORMAL one.glb.json && ! grep -q NORMAL bare.glb.json && echo "normals as asked"
grep -q animations one.glb.json && give_up "one frame is animated"
frames=$(nsdf-dec --info fixture/tiny.nsdf | sed -nE 's/^frames +([0-9]+)/\1/p')
[ "$(grep -o '"path":"scale"' all.glb.json | wc -l)" = "$frames" ] && echo "a track for each frame"
grep -o '"generator":"nsdf-dec' all.glb.json
grep -o '"seconds":0[.0-9]*' all.glb.json | head -n 2 | wc -l

fails 2 "cannot tell the format" nsdf-dec fixture/tiny.nsdf -o x.gltf
fails 1 "No such file" nsdf-dec fixture/tiny.nsdf -o missing/x.glb

# Another program's reader finds as many vertices and triangles.
if command -v assimp >/dev/null; then
    nsdf-dec -q fixture/tiny.nsdf -o one.ply --frames 1 --resolution 24
    count() { assimp info "$1" | sed -nE "s/^$2: +([0-9]+).*/\1/p" | head -n 1; }
    vertices=$(head -n 12 one.ply | sed -nE 's/^element vertex ([0-9]+)/\1/p' | head -n 1)
    faces=$(head -n 12 one.ply | sed -nE 's/^element face ([0-9]+)/\1/p' | head -n 1)
    [ "$(count one.glb Vertices)" = "$vertices" ] && [ "$(count one.glb Faces)" = "$faces" ] ||
        give_up "assimp: $(count one.glb Vertices) vertices, $(count one.glb Faces) faces, not $vertices, $faces"
    [ "$(count all.glb Meshes)" = "$frames" ] || give_up "assimp: $(count all.glb Meshes) meshes"
fi

# A film that nsdf-dec writes is the sequence it shows: as many frames, at its own rate, the same surfaces.
answer=$(nsdf-dec -o /dev/null --format glb fixture/tiny.nsdf --frames 0 2>&1)
[[ $answer != *"without tinygltf"* ]] || skip "no glTF in this build"
nsdf-dec -q fixture/tiny.nsdf -o film.glb --resolution 24
nsdf-dec -q fixture/tiny.nsdf -o f_%d.obj --resolution 24
nsdf-cmp film.glb f_%d.obj --measures none --samples 200 --csv | cut -d, -f1,6,7
nsdf-cmp film.glb fixture/tiny.nsdf --resolution 24 --measures none --samples 200 --csv | cut -d, -f1,6,7 | tail -n 1
nsdf-enc --check film.glb | sed 's/:.*//'
nsdf-enc -q "${tiny[@]}" --no-verify -o film.nsdf film.glb
nsdf-dec --info film.nsdf | grep -E 'frames|frame rate'
# The same as its frames, in segments too.
nsdf-enc -q "${tiny[@]}" --no-verify --fps 24 --segment 0.1 -o parts.nsdf film.glb
nsdf-enc -q "${tiny[@]}" --no-verify --fps 24 --segment 0.1 -o files.nsdf f_%d.obj
nsdf-cmp film.glb parts.nsdf --measures none --samples 200 --csv | wc -l
[ $(($(size_of parts.nsdf) * 10)) -lt $(($(size_of files.nsdf) * 11)) ] || give_up "not as good as files"
# At another rate it is said that frames are lost.
nsdf-enc "${tiny[@]}" --no-verify --fps 10 -o slow.nsdf film.glb 2>err
head -n 1 err
nsdf-dec --info slow.nsdf | grep 'frames'
head -c 3000 film.glb >short.glb
fails 1 'short.glb' nsdf-enc -q "${tiny[@]}" -o x.nsdf short.glb
# What is no glTF: the byte, and what was expected there.
broken() { # NAME MESSAGE
    fails 1 "$1: $2" nsdf-enc --check "$1"
}
printf '\x8a\x01random bytes' >random.glb
broken random.glb "byte 0: expected 'glTF'"
printf '{"asset": {"version": "2.0"}}' >text.glb
broken text.glb "byte 0: expected 'glTF'"
printf 'glTF\x02' >header.glb
broken header.glb 'byte 5: the file ends, expected a header of 12 bytes'
cp film.glb version.glb && poke version.glb 4 01
broken version.glb 'byte 4: the version is 1, expected 2'
head -c 3000 film.glb >cut.glb
broken cut.glb 'byte 8: the length is '
cp film.glb low.glb && poke low.glb 8 05 && poke low.glb 9 00 && poke low.glb 10 00
broken low.glb 'byte 8: the length is 5, expected at least 12'
cp film.glb chunk.glb && poke chunk.glb 15 01
broken chunk.glb 'byte 12: the length of a chunk is '
cp film.glb type.glb && poke type.glb 16 6a
broken type.glb "byte 16: expected 'JSON'"
cp film.glb json.glb && poke json.glb 20 21
broken json.glb 'byte 20: JSON '
printf 'v 0 0 0\n' >object.gltf
broken object.gltf "byte 0: expected '{'"
printf '\n {"asset":\n {"version": 2.0' >open.gltf
broken open.gltf 'byte 28: JSON '
printf '{"asset": }' >value.gltf
broken value.gltf 'byte 10: JSON '
: >empty.gltf
broken empty.gltf "byte 0: expected '{'"

# A film that nsdf-dec writes is the sequence it shows: as many frames, at its own rate, the same surfaces.
answer=$(nsdf-dec -o /dev/null --format glb fixture/tiny.nsdf --frames 0 2>&1)
[[ $answer != *"without tinygltf"* ]] || skip "no glTF in this build"
nsdf-dec -q fixture/tiny.nsdf -o film.glb --resolution 24
nsdf-dec -q fixture/tiny.nsdf -o f_%d.obj --resolution 24
nsdf-cmp film.glb f_%d.obj --measures none --samples 200 --csv | cut -d, -f1,6,7
nsdf-cmp film.glb fixture/tiny.nsdf --resolution 24 --measures none --samples 200 --csv | cut -d, -f1,6,7 | tail -n 1
nsdf-enc --check film.glb | sed 's/:.*//'
nsdf-enc -q "${tiny[@]}" --no-verify -o film.nsdf film.glb
nsdf-dec --info film.nsdf | grep -E 'frames|rate  '
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

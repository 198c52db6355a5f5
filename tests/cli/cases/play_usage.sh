command -v nsdf-play >/dev/null || skip "nsdf-play is not built"
unset DISPLAY WAYLAND_DISPLAY
fails 1 "--offscreen" nsdf-play fixture/tiny.nsdf
fails 2 "no input file" nsdf-play --offscreen x.png
fails 2 "numbered names" nsdf-play fixture/tiny.nsdf --offscreen x.png
fails 2 "one picture" nsdf-play fixture/tiny.nsdf --offscreen - --format png
fails 2 "--size" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --size 10x10
fails 2 "--size" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --size 640
fails 2 "--camera" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --camera 10
fails 2 "--camera" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --camera 10,90
fails 2 "--up" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --up w
fails 2 "--speed" nsdf-play fixture/tiny.nsdf --speed 1/100
fails 2 "--mode" nsdf-play fixture/tiny.nsdf --mode shiny
fails 2 "go with --offscreen" nsdf-play fixture/tiny.nsdf --fps 25
fails 2 "--transparent" nsdf-play fixture/tiny.nsdf --offscreen - --transparent
fails 2 "out of range" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --times 99
fails 2 "--compare" nsdf-play fixture/tiny.nsdf --compare fixture/frames
fails 2 "--heatmap goes" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --heatmap
fails 2 "--heatmap-max" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --heatmap-max 0
fails 1 "nowhere" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --compare nowhere
fails 1 "0 OBJ meshes, but the file has 6" nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --compare fixture/empty
cp -r fixture/frames damaged
damaged=$(ls -d damaged/* | sed -n 3p)
echo "f 1 2 x" >"$damaged"
fails 1 "$damaged:1: " nsdf-play fixture/tiny.nsdf --offscreen x_%d.png --compare damaged
rm -r damaged
fails 1 missing.nsdf nsdf-play missing.nsdf --offscreen x_%d.png
head -c 100 fixture/tiny.nsdf >short.nsdf
fails 1 short.nsdf nsdf-play short.nsdf --offscreen x_%d.png
fails 1 short.nsdf nsdf-play short.nsdf
rm short.nsdf
ls | grep '^x' && give_up "pictures left behind"
mkdir pictures
nsdf-play -q fixture/tiny.nsdf --offscreen pictures/p_%02d.png --frames 0-2 --size 64x48
no_leftovers pictures p_00.png p_01.png p_02.png
nsdf-play -q fixture/tiny.nsdf --offscreen - --frames 0-2 --size 64x48 >film.y4m
head -n 1 film.y4m
size_of film.y4m
nsdf-play -q fixture/tiny.nsdf --offscreen both.png --times 0 --size 64x48 --compare fixture/frames/
nsdf-play -q fixture/tiny.nsdf --offscreen heat.png --times 0 --size 65x48 --compare fixture/frames --heatmap
for name in both heat; do [ "$(size_of "$name.png")" -gt 500 ] || give_up "$name.png is empty"; done
# Of another number of meshes, those nearest in time: of 0, 2 and 4 the last for the last frame.
i=0
mkdir some some_more short same_names
for mesh in fixture/frames/*.obj; do
    [ $((i % 2)) = 1 ] || cp "$mesh" some/mesh_$((i + 10)).obj
    [ $i -gt 2 ] || cp "$mesh" short/mesh_$i.obj
    [ $i -gt 2 ] || cp "$mesh" same_names/$(printf '%*s' $((i + 1)) | tr ' ' m).obj
    [ $i = 4 ] && cp "$mesh" one.obj
    i=$((i + 1))
done
last=(--offscreen x.png --size 64x48 --frames 5 --no-overlay)
nsdf-play fixture/tiny.nsdf "${last[@]}" --compare some 2>err
grep -c "some: 3 OBJ meshes for 6 frames: of each frame the mesh nearest in time is shown" err
cp x.png nearest.png
cp some/* some_more && rm some_more/mesh_14.obj && cp one.obj some_more/mesh_15.obj
nsdf-play -q fixture/tiny.nsdf "${last[@]}" --compare some_more
same nearest.png x.png
cp some/mesh_10.obj some_more/mesh_15.obj
nsdf-play -q fixture/tiny.nsdf "${last[@]}" --compare some_more
cmp -s nearest.png x.png || echo "another mesh"
fails 1 'the last mesh is frame 2, expected about 5' nsdf-play fixture/tiny.nsdf "${last[@]}" --compare short
fails 1 'expected a number of its own in each name' nsdf-play fixture/tiny.nsdf "${last[@]}" --compare same_names

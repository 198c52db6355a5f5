mkdir two && cp fixture/frames/*0.obj fixture/frames/*1.obj two
fails 1 'has 6 frames' nsdf-cmp fixture/frames two
fails 1 'missing.obj' nsdf-cmp missing.obj fixture/frames
fails 1 'missing.nsdf' nsdf-cmp fixture/frames missing.nsdf
fails 1 'index.obj:4' nsdf-cmp fixture/bad/index.obj fixture/bad/index.obj
fails 1 'no_faces.obj' nsdf-cmp two/*0.obj fixture/bad/no_faces.obj
printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
fails 1 'flat.obj' nsdf-cmp two/*0.obj flat.obj
fails 2 'must be meshes' nsdf-cmp fixture/tiny.nsdf fixture/frames
fails 2 '--resolution' nsdf-cmp --resolution 64 two two
fails 2 'expected two' nsdf-cmp two
fails 2 '--measures' nsdf-cmp --measures d3 two two
fails 2 '--samples' nsdf-cmp --samples 0 two two
fails 2 '--units' nsdf-cmp --units metres two two
fails 2 '.ply' nsdf-cmp --heatmap h.obj two two
fails 2 '%04d' nsdf-cmp --heatmap h.ply two two
fails 2 'no frame 9' nsdf-cmp --frames 9 two two
fails 2 'not a number' nsdf-cmp --frames 0- two two
fails 2 'takes no value' nsdf-cmp --csv=1 two two
fails 2 'needs a value' nsdf-cmp two two --seed
fails 2 "unknown option '--mean'" nsdf-cmp --mean two two
fails 2 "unknown option '-z'" nsdf-cmp -z two two
fails 1 'no/such' nsdf-cmp -o no/such/file two two --samples 100
nsdf-cmp --common fixture/frames two --samples 100 --measures none --csv 2>err | wc -l
grep -c 'the first 2 are compared' err

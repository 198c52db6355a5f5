fails 1 missing.obj nsdf-enc "${tiny[@]}" -o a.nsdf missing.obj
fails 1 fixture/empty nsdf-enc "${tiny[@]}" -o a.nsdf fixture/empty
fails 1 no_faces.obj nsdf-enc "${tiny[@]}" -o a.nsdf fixture/bad/no_faces.obj
fails 1 nan.obj:2 nsdf-enc "${tiny[@]}" -o a.nsdf fixture/bad/nan.obj
fails 1 index.obj:4 nsdf-enc "${tiny[@]}" -o a.nsdf fixture/bad/index.obj
fails 1 'none_%04d.obj' nsdf-enc "${tiny[@]}" -o a.nsdf 'fixture/none_%04d.obj'
no_leftovers . fixture

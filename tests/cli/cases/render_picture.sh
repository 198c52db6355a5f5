command -v nsdf-render >/dev/null || skip "nsdf-render is not in this build"
nsdf-render --size 32 -o sheet.png fixture/frames/metaballs_0000.obj fixture/frames/metaballs_0001.obj
# Signature, and width and height of the header: two tiles of 32.
od -An -tx1 -N 24 sheet.png | tr -d ' \n'
echo
fails 1 missing.obj nsdf-render -o no.png missing.obj
fails 1 index.obj nsdf-render -o no.png fixture/bad/index.obj
fails 1 nowhere nsdf-render --size 16 -o nowhere/no.png fixture/frames/metaballs_0000.obj
fails 2 OBJ nsdf-render -o no.png
no_leftovers . fixture sheet.png

# Colours: the ends of the ramp where the distance is 0 and at the top of the scale, one in between; no partial files.
mkdir a b
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n' >a/0.obj
printf 'v 0 0 0\nv 1 0 .25\nv 1 1 .5\nv 0 1 .125\nf 1 2 3\nf 1 3 4\n' >b/0.obj
nsdf-cmp -q a b --units world --heatmap-max .25 --heatmap h.ply -o r.txt --samples 100
sed -n '/^end_header/q;p' h.ply | tail -n +3
start=$(grep -abo end_header h.ply | cut -d: -f1)
for vertex in 0 1 2 3; do
    od -An -tu1 -j $((start + 11 + 15 * vertex + 12)) -N 3 h.ply | tr -s ' '
done
# It reads back as the mesh that was measured.
nsdf-cmp b h.ply --samples 100 --csv --measures none | cut -d, -f6-12
mkdir cut && cp fixture/frames/*_000[01].obj cut && echo 'v 0 0 x' >>cut/metaballs_0001.obj
fails 1 'cut/metaballs_0001.obj' nsdf-cmp cut cut --samples 100 --heatmap c_%d.ply -o c.txt
mkdir two flat && cp fixture/frames/*_000[01].obj two && cp two/* flat
printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat/metaballs_0001.obj
fails 1 'flat/metaballs_0001.obj: ' nsdf-cmp two flat --samples 100 --heatmap c_%d.ply -o c.txt
fails 2 'same file' nsdf-cmp a b --heatmap r.ply -o r.ply
no_leftovers . fixture a b cut flat two h.ply r.txt

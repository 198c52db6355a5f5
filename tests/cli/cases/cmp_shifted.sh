# Two squares a quarter apart: every distance is the shift, and the peak is the square's side.
mkdir a b
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n' >a/0.obj
printf 'v 0 0 .25\nv 1 0 .25\nv 1 1 .25\nv 0 1 .25\nf 1 2 3 4\n' >b/0.obj
nsdf-cmp a b --units world --csv --measures normals,shapes | cut -d, -f6-12,14-16,18-19,22 |
    sed "s/0.25000[0-9]*/0.25/g; s/16.81241[0-9]*/16.81241/"
nsdf-cmp a b --csv --measures none | cut -d, -f6,13,15-20 | sed "s/0.17677[0-9]*/0.17677/"
nsdf-cmp a b --measures none --units world | grep -E '^(mean|Hausdorff|PSNR)' | tr -s ' '
nsdf-cmp a b --measures none --peak 2 | grep PSNR | tr -s ' '

for name in metaballs walker knot wave-box; do
    nsdf-sample "$name" --frames 2 --resolution 20 -q -o a
    nsdf-sample "$name" --frames 2 --resolution 20 -q -o b
    diff -r a b
    nsdf-sample "$name" --frames 2 --resolution 20 --seed 2 -q -o c
    if cmp -s "a/${name}_0000.obj" "c/${name}_0000.obj"; then give_up "the seed changes nothing"; fi
done
find a -name '*.obj' -printf '%f\n' | LC_ALL=C sort

fails 1 missing.nsdf nsdf-dec -o null: missing.nsdf
fails 1 nsdf nsdf-dec -o null: fixture/frames/metaballs_0000.obj
: >empty.nsdf
fails 1 empty.nsdf nsdf-dec -o null: empty.nsdf
size=$(size_of fixture/tiny.nsdf)
for keep in 5 15 40 $((size / 2)) $((size - 1)); do
    head -c "$keep" fixture/tiny.nsdf >short.nsdf
    fails 1 short.nsdf nsdf-dec -o null: short.nsdf
done
for at in 20 60 $((size / 2)) $((size - 30)); do
    cp fixture/tiny.nsdf flipped.nsdf
    chmod u+w flipped.nsdf
    flip flipped.nsdf "$at"
    fails 1 flipped.nsdf nsdf-dec --verify flipped.nsdf
done

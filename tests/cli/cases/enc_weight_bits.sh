# Fewer bits, smaller file; every one can be verified.
last=999999999
for bits in 32 16 12 8 5; do
    nsdf-enc -q "${tiny[@]}" --width 32 --no-verify --weight-bits "$bits" -o "b$bits.nsdf" fixture/frames
    nsdf-dec -q --verify "b$bits.nsdf" >verified
    size=$(size_of "b$bits.nsdf")
    [ "$size" -lt "$last" ] || give_up "$bits bits take $size bytes, the step before took $last"
    last=$size
    echo "$bits bits: smaller"
done

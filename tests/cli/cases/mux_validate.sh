# Everything that is wrong is printed, with its chunk and byte.
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
nsdf-mux -q "$walker" "$walker" "$walker" -o whole.nsdf
nsdf-mux --validate whole.nsdf
offsets=$(nsdf-mux --info whole.nsdf | sed -nE 's/.*"offset": ([0-9]+).*/\1/p' | tr '\n' ' ')
read -r one two three <<<"$offsets"

# damaged NAME OFFSET...: a copy with a bit flipped at these places
damaged() {
    cp whole.nsdf "$1"
    for offset in "${@:2}"; do
        flip "$1" "$offset"
    done
    nsdf-mux --validate "$1" && give_up "$1 is said to be sound"
    return 0
}
{
    damaged segment.nsdf $((one + 500))
    damaged segments.nsdf $((one + 500)) $((three + 12000))
    damaged head.nsdf 40
    damaged index.nsdf 200
    damaged length.nsdf $((two + 9))
    damaged end.nsdf $(($(size_of whole.nsdf) - 1))
    head -c 40000 whole.nsdf >short.nsdf
    nsdf-mux --validate short.nsdf && give_up "short.nsdf is said to be sound"
    nsdf-mux --validate segment.nsdf whole.nsdf short.nsdf && give_up "success in spite of damage"
    fails 1 "segment.nsdf: SEGM, byte" nsdf-mux segment.nsdf -o out.nsdf
    fails 1 "segment.nsdf: SEGM, byte" nsdf-mux --info segment.nsdf
    fails 1 "not the signature" nsdf-mux --validate fixture/bad/index.obj
} 2>&1
[ ! -e out.nsdf ] || give_up "a failed command left a file"

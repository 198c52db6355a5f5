# A box in a box: of both, the outer one counts alone.
box() { # HALF_SIDE FIRST_VERTEX
    for i in 0 1 2 3 4 5 6 7; do
        echo "v $((i & 1 ? $1 : -$1)) $((i & 2 ? $1 : -$1)) $((i & 4 ? $1 : -$1))"
    done
    for quad in '0 2 3 1' '4 5 7 6' '0 1 5 4' '2 6 7 3' '0 4 6 2' '1 3 7 5'; do
        read -r a b c d <<<"$quad"
        echo "f $((a + $2)) $((b + $2)) $((c + $2)) $((d + $2))"
    done
}
box 2 1 >one.obj
{ box 2 1 && box 1 9; } >two.obj
cmp=(nsdf-cmp --samples 1000 --measures none)
"${cmp[@]}" --units world two.obj one.obj | grep -c hidden || true
"${cmp[@]}" --units world two.obj one.obj | grep largest
"${cmp[@]}" --units world --outer two.obj one.obj | grep -e hidden -e largest
"${cmp[@]}" --outer --csv two.obj two.obj | awk -F, '{ print $(NF - 1), $NF, $11 }' | sed 1q
"${cmp[@]}" --outer --csv two.obj two.obj | awk -F, 'NR > 1 { printf "%.3f %.3f %g\n", $(NF - 1), $NF, $11 }'
"${cmp[@]}" --outer --json two.obj one.obj | grep -o -e '"ref_hidden_mean": 0.[0-9]' -e 'dec_hidden_max.*'
# A decoded file hides nothing, and what hides nothing has the same figures.
"${cmp[@]}" --csv fixture/frames fixture/tiny.nsdf >plain.csv
"${cmp[@]}" --csv --outer fixture/frames fixture/tiny.nsdf | tee outer.csv | sed 1q | grep -o 'ref_hidden.*'
cut -d, -f1-25 outer.csv >cut.csv
same plain.csv cut.csv

# What nsdf-dec writes can be encoded, in every format, and is the same surface.
file=$(ls fixture/*.nsdf | head -n 1)
for kind in obj ply stl glb; do
    if ! nsdf-dec -q "$file" --frames 0-2 --resolution 32 -o "f_%d.$kind" 2>why; then
        grep -q glTF why && skip "no glTF"
        give_up "$(<why)"
    fi
    nsdf-enc --check -q "f_%d.$kind" | sed 's/, . of them not clean//; s/; of each: .*//'
    mkdir "$kind"
    mv f_*."$kind" "$kind"
    nsdf-cmp obj "$kind" --measures none --samples 500 | awk '$1 == "mean" { print ($2 + $3 < 1e-6 ? "same" : $0) }'
done

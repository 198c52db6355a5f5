for shape in sphere bowl sheet cloak twosided fin walled nested crossing seams moebius; do
    nsdf-dirty "$shape" --frames 2 -o "$shape"
    printf '%s: ' "$shape"
    nsdf-enc --check "$shape" | tail -n 1
done
for fault in flip=0.1 remove=0.01 split broken inward duplicate=0.1 sliver=0.1 unused=3 nan=3 scale=1e-12 scale=1e9; do
    nsdf-dirty sphere "$fault" --frames 1 -o "sphere-$fault"
    nsdf-enc --check "sphere-$fault" | head -n 1
done

# What cannot be encoded is named, with its line, and the others are still looked at.
nsdf-dirty sphere badnan --frames 1 -o bad
code=0
nsdf-enc --check bad sphere >bad.txt || code=$?
[ "$code" = 1 ] || give_up "a bad frame ended with $code"
cat bad.txt
nsdf-enc --check --shell none bowl | tail -n 1
nsdf-enc --check --shell 0.25 sheet | tail -n 1

# Numbers that are not there.
mkdir gaps
for i in 1 2 5 9 10; do cp sphere/dirty_0000.obj "gaps/f_$i.obj"; done
nsdf-enc --check -q gaps
nsdf-enc --check=json gaps -o gaps.json
grep -q '"missing": "3-4, 6-8", "interpolated": 5' gaps.json || give_up "no missing numbers: $(<gaps.json)"
grep -q '"frame": 8, "file": "gaps/f_9.obj"' gaps.json || give_up "not frame 8: $(<gaps.json)"
grep -q '"encodable": true,$' gaps.json || give_up "not encodable: $(<gaps.json)"
nsdf-enc --check=json bad >bad.json || true
grep -q '"refused": 1, ' bad.json || give_up "not refused: $(<bad.json)"
if command -v python3 >/dev/null; then
    python3 -m json.tool gaps.json >/dev/null && python3 -m json.tool bad.json >/dev/null || give_up "not JSON"
fi
fails 2 json nsdf-enc --check=xml sphere
fails 2 thickness nsdf-enc --check --shell 0 sphere

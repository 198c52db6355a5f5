nsdf-dec --info fixture/tiny.nsdf >info
grep -qi frames info || give_up "no frames in $(<info)"
nsdf-dec --info --json fixture/tiny.nsdf >info.json
grep -q 'parameters *[1-9]' info || give_up "no number of parameters in $(<info)"
[[ $(<info.json) == '{'*'}' ]] || give_up "not JSON: $(<info.json)"
grep -q '^  "parameters": [1-9]' info.json || give_up "no number of parameters in $(<info.json)"
if command -v python3 >/dev/null; then
    python3 -m json.tool info.json >/dev/null || give_up "not JSON: $(<info.json)"
fi
nsdf-dec --verify fixture/tiny.nsdf >verified
echo "info, json, verify"

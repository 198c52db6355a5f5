nsdf-enc -q "${tiny[@]}" --report report.json -o a.nsdf fixture/frames
grep -q '"frames": 6' report.json || give_up "the report does not say 6 frames: $(<report.json)"
grep -q "\"bytes\": $(size_of a.nsdf)" report.json || give_up "the report gives another size: $(<report.json)"
if command -v python3 >/dev/null; then
    python3 -m json.tool report.json >/dev/null || give_up "not JSON: $(<report.json)"
fi
no_leftovers . a.nsdf fixture report.json

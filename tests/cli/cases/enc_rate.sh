# Sizes, bitrates and errors that are asked for.
short=("${tiny[@]}" --blocks 80 --bones 4 -q --no-verify)
nsdf-enc "${short[@]}" --size 4000 --report report.json -o a.nsdf fixture/frames
size=$(size_of a.nsdf)
[ "$size" -le 4000 ] && [ "$size" -ge 3880 ] || give_up "asked for 4000 bytes, got $size"
nsdf-dec -q --verify a.nsdf >verified
grep -q '"target": {"size": 4000, "met": true, "rounds": \[$' report.json || give_up "no trail: $(<report.json)"
for kind in probe fit quantise; do
    grep -Eq "\"kind\": \"$kind\", \"steps\": [0-9]+, \"blocks\": [0-9]+, \"bones\": [0-9]+, \"pose_step\": .*, \
\"coefficient_step\": .*, \"motion_rate\": .*, \"bytes\": [0-9]+, \"error\": " report.json ||
        give_up "no round '$kind': $(<report.json)"
done
grep -q "\"kind\": \"quantise\".*\"bytes\": $size, \"error\": null}" report.json ||
    give_up "the last round has another size: $(<report.json)"
if command -v python3 >/dev/null; then
    python3 -m json.tool report.json >/dev/null || give_up "not JSON: $(<report.json)"
fi
# 6 frames at 25 a second last 0.2 s.
nsdf-enc "${short[@]}" --bitrate 160 -o b.nsdf fixture/frames
same a.nsdf b.nsdf
nsdf-enc "${tiny[@]}" --size 3000 -v --no-verify -o c.nsdf fixture/frames 2>messages
grep -q 'round 1, probe: width [0-9]*, [0-9.]* bits, [0-9]* steps: [0-9]* bytes' messages ||
    give_up "no line for the first round: $(<messages)"
size=$(size_of c.nsdf)
[ "$size" -le 3000 ] && [ "$size" -ge 2910 ] || give_up "asked for 3000 bytes, got $size"
rm -- *.nsdf report.json verified messages
# An error out of reach: the file is there all the same.
fails 3 '--max-error 1e-06 is missed by' nsdf-enc "${tiny[@]}" --blocks 30 --bones 2 -q --steps 20 --max-error 1e-6 \
    --report report.json -o a.nsdf fixture/frames
grep -q '"target": {"max_error": 1e-06, "met": false' report.json || give_up "not said: $(<report.json)"
grep -q '"kind": "verify".*"error": [0-9]' report.json || give_up "no verified error: $(<report.json)"
nsdf-dec -q --verify a.nsdf >verified
rm -- a.nsdf report.json verified
fails 1 '600 bytes are too few: the least' nsdf-enc "${short[@]}" --size 600 -o a.nsdf fixture/frames
fails 2 'expected 500' nsdf-enc "${short[@]}" --size 20 -o a.nsdf fixture/frames
fails 2 '--size and --max-error cannot be given together' nsdf-enc --size 9000 --max-error 1e-3 -o a.nsdf fixture/frames
fails 2 '--bitrate and --size cannot be given together' nsdf-enc --bitrate 9 --size 9000 -o a.nsdf fixture/frames
fails 2 "--size: 'big' is not a whole number" nsdf-enc --size big -o a.nsdf fixture/frames
fails 2 "--size: '0' is not a whole number of bytes from 1 up" nsdf-enc --size 0 -o a.nsdf fixture/frames
fails 2 "--bitrate: '-3' is not a number above 0" nsdf-enc --bitrate -3 -o a.nsdf fixture/frames
fails 2 "--max-error: '0' is not a number above 0" nsdf-enc --max-error 0 -o a.nsdf fixture/frames
fails 2 'expected 1e-06 to 0.1' nsdf-enc --max-error 0.5 -o a.nsdf fixture/frames
fails 2 'without verifying' nsdf-enc --max-error 1e-3 --no-verify -o a.nsdf fixture/frames
fails 2 'range coder only' nsdf-enc --size 9000 --preset thesis -o a.nsdf fixture/frames
no_leftovers . fixture

# Frames 1, 3 and 4 of six are fitted, in whatever order they are named: the file has the frames from 1 to 4.
nsdf-enc -q "${tiny[@]}" --frames 3-4,1,3 --fps 24 --report report.json -o some.nsdf fixture/frames
nsdf-dec -q --resolution 12 -o hash: some.nsdf | wc -l
grep -q '"input": {"frames": 3,' report.json || give_up "not 3 frames: $(<report.json)"
grep -q '"frames": "3-4,1,3"' report.json || give_up "the list is not in the report: $(<report.json)"
# A step is a list of its own.
nsdf-enc -q "${tiny[@]}" --frames 0-5/5 --fps 24 -o ends.nsdf fixture/frames
nsdf-enc -q "${tiny[@]}" --frame-step 5 --fps 24 -o step.nsdf fixture/frames
same ends.nsdf step.nsdf
fails 2 'no frame 6' nsdf-enc -q "${tiny[@]}" --frames 0-6 -o a.nsdf fixture/frames
fails 2 'runs backwards' nsdf-enc -q "${tiny[@]}" --frames 3-1 -o a.nsdf fixture/frames
fails 2 'not a number or a range' nsdf-enc -q "${tiny[@]}" --frames 1,,2 -o a.nsdf fixture/frames
fails 2 'cannot be given together' nsdf-enc --frames 1 --frame-step 2 -o a.nsdf fixture/frames
no_leftovers . ends.nsdf fixture report.json some.nsdf step.nsdf

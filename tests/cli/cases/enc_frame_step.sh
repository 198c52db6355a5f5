# Every second frame is fitted (and the last one); the file still has all six.
nsdf-enc -q "${tiny[@]}" --frame-step 2 --fps 24 -o half.nsdf fixture/frames
nsdf-dec -q --resolution 12 -o hash: half.nsdf | wc -l
nsdf-enc -q "${tiny[@]}" --frame-step 100 --fps 24 -o ends.nsdf fixture/frames
nsdf-dec -q --resolution 12 -o hash: ends.nsdf | wc -l

fails 2 --frobnicate nsdf-enc --frobnicate -o a.nsdf fixture/frames
fails 2 help nsdf-enc
fails 2 help nsdf-enc fixture/frames
fails 2 help nsdf-enc -o a.nsdf
fails 2 --fps nsdf-enc --fps -3 -o a.nsdf fixture/frames
fails 2 --preset nsdf-enc --preset warp -o a.nsdf fixture/frames
fails 2 --entropy nsdf-enc --entropy zip -o a.nsdf fixture/frames
fails 2 layers nsdf-enc --layers 99 -o a.nsdf fixture/frames
fails 2 '--level-spacing goes with moving blocks' nsdf-enc --blocks 0 --level-spacing 4 -o a.nsdf fixture/frames
fails 2 'takes no value' nsdf-enc --no-verify=1 -o a.nsdf fixture/frames
# A wildcard behind -o must not write over the first frame.
fails 2 'ends in .obj' nsdf-enc -o fixture/frames/*.obj
fails 2 'ends in .PLY' nsdf-enc -o a.PLY fixture/frames
fails 2 'same file' nsdf-enc --report a.nsdf -o a.nsdf fixture/frames
fails 2 "--batch-points: 'many' is not a whole number" nsdf-enc --batch-points many -o a.nsdf fixture/frames
fails 2 "--batch-frames: '-1' is not a whole number" nsdf-enc --batch-frames -1 -o a.nsdf fixture/frames
fails 2 'batch frames is 5000, expected 1 to 4096' nsdf-enc --batch-frames 5000 -o a.nsdf fixture/frames
for target in --size=40000 --bitrate=8 --max-error=1e-3; do
    fails 2 "${target%=*} and --time cannot be given together" nsdf-enc --time 60 $target -o a.nsdf fixture/frames
done
no_leftovers . fixture

# Frames 0, 1, 3, 4 of a sequence: the files' numbers put them at their times, and frame 2 is interpolated.
quick=(nsdf-enc -q "${tiny[@]}" --no-verify --fps 24)
mkdir gap tens
for i in 0 1 3 4; do
    cp "fixture/frames/metaballs_000$i.obj" "gap/walk_$i.obj"
    cp "fixture/frames/metaballs_000$i.obj" "tens/f_0$i""0.obj"
done
"${quick[@]}" -o gap.nsdf gap 2>err
nsdf-dec --info gap.nsdf | grep frames
# The same as leaving the frame out by hand, in one fit and in segments.
"${quick[@]}" --frames 0-1,3-4 -o left_out.nsdf fixture/frames
same left_out.nsdf gap.nsdf
"${quick[@]}" -o files.nsdf gap/*.obj
same left_out.nsdf files.nsdf
"${quick[@]}" -o tens.nsdf tens
same left_out.nsdf tens.nsdf
"${quick[@]}" --segment 0.1 -o parts.nsdf gap
"${quick[@]}" --segment 0.1 --frames 0-1,3-4 -o parts_left_out.nsdf fixture/frames
same parts_left_out.nsdf parts.nsdf
# One line says so; without numbers files follow each other.
nsdf-enc "${tiny[@]}" --no-verify --fps 24 -o gap.nsdf gap 2>err
grep -o 'no file .*' err
"${quick[@]}" --numbers ignore --report report.json -o close.nsdf gap
grep -q '"fps": \[24, 1\], "numbers": "ignore"' report.json || give_up "not in the report: $(<report.json)"
nsdf-dec --info close.nsdf | grep frames
# Times of a list file.
printf 'gap/walk_0.obj 0\ngap/walk_1.obj 0.0417\ngap/walk_3.obj 0.125\ngap/walk_4.obj\t0.1667\n' >times.txt
"${quick[@]}" -o times.nsdf times.txt
same left_out.nsdf times.nsdf
fails 1 'times.txt:3: 0.125 s is not the time of a frame at 25 frames a second; all times fit --fps 24' \
    nsdf-enc -q "${tiny[@]}" -o x.nsdf times.txt
# nsdf-cmp looks at the same times, at the rate of the file.
for input in gap times.txt; do
    nsdf-cmp "$input" gap.nsdf --samples 100 --measures none --csv | grep -c '^[0-9]'
    nsdf-cmp "$input" gap.nsdf --samples 100 --measures none --csv >"$(basename "$input").csv"
done
same gap.csv times.txt.csv
cmp=(nsdf-cmp --samples 100 --measures none --csv --units world)
"${cmp[@]}" --common gap fixture/tiny.nsdf >some.csv 2>/dev/null
"${cmp[@]}" --frames 0-1,3-4 fixture/frames fixture/tiny.nsdf >all.csv
same some.csv all.csv
nsdf-cmp --numbers ignore gap close.nsdf --samples 100 --measures none --csv | grep -c '^[0-9]'
fails 1 'has 5 frames' nsdf-cmp gap close.nsdf
mkdir full && for i in 0 1 2 3 4; do cp "fixture/frames/metaballs_000$i.obj" full; done
fails 1 'has no frame 2' nsdf-cmp full gap
"${cmp[@]}" --common full gap | cut -d, -f1,6 | tr '\n' ' '
# Chosen frames are numbered in time; a step counts files.
fails 2 'is missing' "${quick[@]}" --frames 2 -o x.nsdf gap
fails 2 'no frame 5' "${quick[@]}" --frames 5 -o x.nsdf gap
"${quick[@]}" --frames 1-3 -o some.nsdf gap && nsdf-dec --info some.nsdf | grep frames
fails 2 'none of times|ignore' nsdf-enc --numbers no -o x.nsdf gap
fails 2 'times or ignore' nsdf-cmp --numbers no gap gap

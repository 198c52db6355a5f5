# An .nsdf file gives what its decoded frames give, but for their six decimals.
nsdf-dec -q fixture/tiny.nsdf -o d_%04d.obj
nsdf-cmp fixture/frames fixture/tiny.nsdf --samples 2000 --frames 1-5/2 --csv --measures none >direct.csv
nsdf-cmp fixture/frames d_%04d.obj --samples 2000 --frames 1-5/2 --csv --measures none >files.csv
cut -d, -f1 direct.csv | tr '\n' ' '
paste -d, direct.csv files.csv | awk -F, 'NR > 1 { d = $6 - $31; if (d < 0) d = -d;
    if (!($6 > 0) || d > 1e-4 * $6) bad++ }
    END { print bad + 0, "bad" }'
nsdf-cmp fixture/frames fixture/tiny.nsdf --resolution 12 --samples 500 --frames 0 --heatmap h.ply -o r.txt
head -c 3 h.ply; echo
grep -c 'to decoded' r.txt
nsdf-cmp fixture/frames fixture/tiny.nsdf --samples 500 --frames 0,2 --json -o r.json --heatmap h_%02d.ply
no_leftovers . fixture d_0000.obj d_0001.obj d_0002.obj d_0003.obj d_0004.obj d_0005.obj direct.csv files.csv h.ply \
    r.txt r.json h_00.ply h_02.ply
grep -c '^    "' r.json

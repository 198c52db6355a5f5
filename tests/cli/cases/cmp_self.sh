nsdf-cmp fixture/frames fixture/frames --csv --samples 500 >self.csv
awk -F, 'NR > 1 { for (i = 6; i <= 12; i++) sum += $i; if ($13 != "inf" || $14 != "inf") bad++; sum += $15 + $16 + $17
    if ($18 != $19 || $20 != $21 || $24 != $25) bad++ } END { print NR - 1, "frames:", sum + 0, bad + 0 }' self.csv
nsdf-cmp fixture/frames fixture/frames --samples 500 --threads 1 --json >one.json
nsdf-cmp fixture/frames fixture/frames --samples 500 --threads 3 --json >three.json
same one.json three.json

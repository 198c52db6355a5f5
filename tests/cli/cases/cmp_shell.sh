# The thickened sheet is half the thickness away from the sheet, on both sides of it and all around.
nsdf-dirty sheet --frames 2 -o sheet
nsdf-dirty sphere --frames 2 -o sphere
cmp=(nsdf-cmp --samples 2000 --measures none --csv)
"${cmp[@]}" --units world --shell 0.2 sheet sheet | awk -F, 'NR > 1 { printf "%.2f %.2f %d\n", $6, $11, ($3 > 2 * $5) }'
"${cmp[@]}" --shell auto sheet sheet | awk -F, 'NR > 1 { printf "%.2f\n", $6 * 600 }'
"${cmp[@]}" --shell none sheet sheet | cut -d, -f6 | tail -n 1
# A closed body stays what it is, with whatever option.
"${cmp[@]}" --shell auto sphere sphere >auto.csv
"${cmp[@]}" sphere sphere >plain.csv
same plain.csv auto.csv
# What was encoded is nearer to the thickened sheet than to the sheet.
nsdf-enc -q "${tiny[@]}" --width 32 --steps 400 --shell 0.2 sheet -o sheet.nsdf
for shell in 0.2 none; do
    "${cmp[@]}" --shell $shell sheet sheet.nsdf | cut -d, -f6 | tail -n 1 >$shell.txt
done
awk -v thick="$(<0.2.txt)" -v thin="$(<none.txt)" 'BEGIN { print (thick < thin ? "nearer" : thick " " thin) }'
fails 2 'a thickness above 0' nsdf-cmp --shell 0 sheet sheet

nsdf-dec --help >help.txt
head -n 1 help.txt
for option in --fps --times --frames --resolution --info --json --verify --bench --threads --cpu-mask --format; do
    grep -q -e "$option" help.txt || give_up "--help does not name $option"
done

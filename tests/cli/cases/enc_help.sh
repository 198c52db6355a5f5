nsdf-enc --help >help.txt
head -n 1 help.txt
for option in --fps --preset --frame-step --layers --width --input --activation --steps --seed --threads --weight-bits \
    --entropy --loss --sampling --time-norm --sdf-norm --report --resolution --no-verify; do
    grep -q -e "$option" help.txt || give_up "--help does not name $option"
done

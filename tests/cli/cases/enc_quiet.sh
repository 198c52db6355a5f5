# No carriage return where stderr is no terminal; with -q nothing; data never on stdout.
nsdf-enc "${tiny[@]}" -o a.nsdf fixture/frames >out 2>err
if grep -q $'\r' err; then give_up "progress was printed: $(<err)"; fi
grep -q '^nsdf-enc: ' err || give_up "nothing was said: $(<err)"
[ ! -s out ] || give_up "stdout: $(<out)"
nsdf-enc -q "${tiny[@]}" -o a.nsdf fixture/frames >out 2>err
[ ! -s err ] || give_up "-q printed: $(<err)"
echo "quiet"

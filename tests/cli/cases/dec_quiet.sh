# No carriage return where stderr is no terminal; with -q nothing at all.
nsdf-dec --resolution 16 -o null: fixture/tiny.nsdf 2>err >out
if grep -q $'\r' err out; then give_up "progress was printed"; fi
[ ! -s out ] || give_up "null: printed on stdout: $(<out)"
nsdf-dec -q --resolution 16 -o null: fixture/tiny.nsdf 2>err
[ ! -s err ] || give_up "-q printed: $(<err)"
nsdf-dec --bench --resolution 16 fixture/tiny.nsdf >bench 2>&1
[ -s bench ] || give_up "--bench printed nothing"
echo "quiet"

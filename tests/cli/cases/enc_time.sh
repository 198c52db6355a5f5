# More time than was given is told, with what took it.
nsdf-enc "${tiny[@]}" --time 1e-6 -o a.nsdf fixture/frames 2>err
grep -q 'warning: --time 1e-06 is exceeded: sampling took .* steps .* s, coding and verifying .* s$' err ||
    give_up "nothing tells that the time is exceeded: $(<err)"
nsdf-enc "${tiny[@]}" --time 20 -o b.nsdf fixture/frames 2>err
if grep -q exceeded err; then give_up "20 s were not exceeded: $(<err)"; fi
echo "told"

# The same seed gives the same bytes, for every number of threads; another seed other ones.
quick=(nsdf-enc -q "${tiny[@]}" --no-verify)
"${quick[@]}" --seed 5 -o a.nsdf fixture/frames
"${quick[@]}" --seed 5 -o b.nsdf fixture/frames
"${quick[@]}" --seed 5 --threads 1 -o c.nsdf fixture/frames
"${quick[@]}" --seed 6 -o d.nsdf fixture/frames
same a.nsdf b.nsdf
same a.nsdf c.nsdf
if cmp -s a.nsdf d.nsdf; then give_up "the seed changes nothing"; fi

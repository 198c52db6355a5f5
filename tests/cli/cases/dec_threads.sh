# Meshes are the same for every number of threads.
nsdf-dec --resolution 32 --threads 1 -q -o hash: fixture/tiny.nsdf >one
nsdf-dec --resolution 32 --threads 2 -q -o hash: fixture/tiny.nsdf >two
nsdf-dec --resolution 32 --threads 7 -q -o hash: fixture/tiny.nsdf >seven
same one two
same one seven
[ "$(wc -l <one)" = 6 ] || give_up "expected six hashes: $(<one)"

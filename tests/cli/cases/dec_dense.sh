# The bound in the file makes the sparse search find the surface that looking into every cell finds.
nsdf-dec --resolution 24 -q -o hash: fixture/tiny.nsdf >sparse
nsdf-dec --resolution 24 --dense -q -o hash: fixture/tiny.nsdf >dense
same sparse dense

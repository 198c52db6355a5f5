fails 1 nowhere nsdf-dec --frames 0 -o nowhere/out_%04d.obj fixture/tiny.nsdf
: >file
fails 1 file nsdf-dec --frames 0 -o file/out_%04d.obj fixture/tiny.nsdf
# Two frames need two names.
fails 2 % nsdf-dec --frames 0-1 -o out.obj fixture/tiny.nsdf
fails 2 out_ nsdf-dec --frames 0 -o out_%04d.xyz fixture/tiny.nsdf
no_leftovers . fixture file

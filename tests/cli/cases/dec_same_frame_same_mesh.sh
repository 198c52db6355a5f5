# A frame does not depend on the way it was asked for, nor on those before it.
nsdf-dec --frames 2 --resolution 20 -q -o a.obj fixture/tiny.nsdf
nsdf-dec --resolution 20 -q -o all_%d.obj fixture/tiny.nsdf
same a.obj all_2.obj
nsdf-dec --fps 48 --resolution 20 -q -o fine_%d.obj fixture/tiny.nsdf
same a.obj fine_4.obj
nsdf-dec --frames 2 --resolution 20 -q --format obj -o - fixture/tiny.nsdf >stdout.obj
same a.obj stdout.obj

fails 2 --frobnicate nsdf-dec --frobnicate fixture/tiny.nsdf
fails 2 help nsdf-dec
fails 2 help nsdf-dec fixture/tiny.nsdf
fails 2 --fps nsdf-dec --fps 0 -o null: fixture/tiny.nsdf
fails 2 --fps nsdf-dec --fps 24/0 -o null: fixture/tiny.nsdf
fails 2 --resolution nsdf-dec --resolution many -o null: fixture/tiny.nsdf
fails 2 --threads nsdf-dec --threads -1 -o null: fixture/tiny.nsdf

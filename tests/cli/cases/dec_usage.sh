fails 2 --frobnicate nsdf-dec --frobnicate fixture/tiny.nsdf
fails 2 help nsdf-dec
fails 2 help nsdf-dec fixture/tiny.nsdf
fails 2 --fps nsdf-dec --fps 0 -o null: fixture/tiny.nsdf
fails 2 --fps nsdf-dec --fps 24/0 -o null: fixture/tiny.nsdf
fails 2 --resolution nsdf-dec --resolution many -o null: fixture/tiny.nsdf
fails 2 --threads nsdf-dec --threads -1 -o null: fixture/tiny.nsdf
fails 2 backwards nsdf-dec --frames 5-2 -o null: fixture/tiny.nsdf
fails 2 'frames/out_%04d.obj' nsdf-dec -o fixture/frames fixture/tiny.nsdf
fails 2 'no output' nsdf-dec -o '' fixture/tiny.nsdf
fails 1 'a folder' nsdf-dec -o null: fixture
fails 1 --max-memory nsdf-dec --max-memory 1k -o null: fixture/tiny.nsdf

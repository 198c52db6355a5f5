# The major version is the byte behind the nine of the signature.
cp fixture/tiny.nsdf newer.nsdf
poke newer.nsdf 9 07
fails 1 version nsdf-dec -o null: newer.nsdf

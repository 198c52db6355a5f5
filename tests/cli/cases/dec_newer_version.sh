# The major version is the byte behind the nine of the signature, then the minor one; the CRC-32 of these is at 12.
versioned() {
    cp fixture/tiny.nsdf "$1"
    poke "$1" 9 "$2"
    poke "$1" 10 "$3"
    head -c 12 "$1" | gzip -c | tail -c 8 | head -c 4 | dd of="$1" bs=1 seek=12 conv=notrunc status=none
}
versioned newer.nsdf 07 01
versioned older.nsdf 00 05
fails 1 'the file is of bitstream 7.1, this library reads 0.6' nsdf-dec -o null: newer.nsdf
fails 1 'the file is of bitstream 0.5, this library reads 0.6' nsdf-dec -o null: older.nsdf
fails 1 'the file is of bitstream 0.5, this library reads 0.6' nsdf-mux --info older.nsdf
fails 1 'the file is of bitstream 0.5, this library reads 0.6' nsdf-cmp fixture/frames older.nsdf

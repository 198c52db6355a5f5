# Another coding of the fit is the file that a run of its own gives.
plain=("${tiny[@]}" --quantiser minmax --hard-samples off -q)
nsdf-enc "${plain[@]}" --weight-bits 32 --entropy none --also 6,deflate,b6.nsdf --also 32,zstd,raw.nsdf \
    --report report.json -o first.nsdf fixture/frames
nsdf-enc "${plain[@]}" --weight-bits 6 --entropy deflate -o alone.nsdf fixture/frames
same b6.nsdf alone.nsdf
nsdf-dec -q --verify raw.nsdf >verified
grep -q "\"output\": \"b6.nsdf\", \"weight_bits\": 6, \"entropy\": \"deflate\", \"bytes\": $(size_of b6.nsdf)}" \
    report.json || give_up "b6.nsdf is not in the report: $(<report.json)"
if command -v python3 >/dev/null; then
    python3 -m json.tool report.json >/dev/null || give_up "not JSON: $(<report.json)"
fi
rm -- *.nsdf report.json verified
fails 2 '8,deflate,small.nsdf' nsdf-enc "${plain[@]}" --also 8,deflate -o a.nsdf fixture/frames
fails 2 '4 to 16 bits' nsdf-enc "${plain[@]}" --also 3,none,b.nsdf -o a.nsdf fixture/frames
fails 2 'none of none' nsdf-enc "${plain[@]}" --also 8,zip,b.nsdf -o a.nsdf fixture/frames
fails 2 'another option names' nsdf-enc "${plain[@]}" --also 8,none,a.nsdf -o a.nsdf fixture/frames
fails 2 'another option names' nsdf-enc "${plain[@]}" --also 8,none,b.nsdf --also 6,none,b.nsdf -o a.nsdf fixture/frames
fails 2 'ends in .obj' nsdf-enc "${plain[@]}" --also 8,none,b.obj -o a.nsdf fixture/frames
# Nothing is left of the first file when the second cannot be written.
fails 1 'missing/b.nsdf' nsdf-enc "${plain[@]}" --also 8,none,missing/b.nsdf -o a.nsdf fixture/frames
no_leftovers . fixture

# Files on servers of every kind give the same meshes as local ones; what cannot work says why, in one line.
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
decode=(-q --frames 3,40 --resolution 32 -o hash:)
nsdf-dec "$walker" "${decode[@]}" >local

for mode in ranges no-ranges no-length "drop 3000" "busy 2" "slow 40000" redirect; do
    # The mode's limit is a word of its own.
    # shellcheck disable=SC2086
    serve "$walker" $mode
    nsdf-dec "$url" "${decode[@]}" >remote
    serve_no_more
    echo "$mode: $requests requests, $sent bytes"
    same local remote
done

serve "$walker" ranges
nsdf-dec --info "$url" | sed -n '/^segments/,/^metadata/p'
nsdf-dec --info --json "$url" | grep '"offset"'
nsdf-dec --verify "$url" | sed "s|$url|URL|"
nsdf-dec -v --info "$url" 2>&1 >/dev/null | sed -nE 's/and [0-9]+ bytes of headers/and headers/p'
serve_no_more

for mode in "not-found:status 404" "wrong-range:answered with bytes 1-2048/17552" "changed 1:changed on the server" \
    "silent:no byte came in 1 second" "drop 0:closed the connection too early"; do
    # shellcheck disable=SC2086
    serve "$walker" ${mode%%:*}
    fails 1 "${mode#*:}" nsdf-dec --timeout 1 "$url" -o "out_%d.obj"
    serve_no_more
done
fails 1 "cannot be reached" nsdf-dec http://127.0.0.1:1/x.nsdf -o hash:
fails 2 "--timeout" nsdf-dec http://127.0.0.1:1/x.nsdf -o hash: --timeout 0

# A server may send anything.
serve fixture/frames/"$(ls fixture/frames | head -n 1)" ranges
fails 1 "not the signature" nsdf-dec "$url" -o hash:
serve_no_more
no_leftovers . fixture local remote

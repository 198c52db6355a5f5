# Pictures of a file on a server are those of a local one.
command -v nsdf-play >/dev/null || skip "nsdf-play is not built"
walker=$(dirname "${BASH_SOURCE[0]}")/../../../samples/walker.nsdf
draw=(-q --frames 7 --size 96x64)
nsdf-play "$walker" "${draw[@]}" --offscreen local.png
serve "$walker" "drop" 5000
nsdf-play "$url" "${draw[@]}" --offscreen remote.png
serve_no_more
same local.png remote.png
serve "$walker" not-found
fails 1 "status 404" nsdf-play "$url" --offscreen none.png
unset DISPLAY WAYLAND_DISPLAY
fails 1 "status 404" nsdf-play "$url"
serve_no_more
no_leftovers . fixture local.png remote.png

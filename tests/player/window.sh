#!/usr/bin/env bash
# Plays a file in a window on a display of its own, works its keys and its mouse, and looks at pictures that it saves.
# usage: window.sh NSDF_PLAY FILE WORK_FOLDER [DROP_FILE]     DROP_FILE drops files on windows
set -euo pipefail

play=$1 file=$2 work=$3 drop=${4:-}
# Mesa's driver leaves memory behind, also of a program that only opens a window, and cannot be named once it is
# unloaded.
export ASAN_OPTIONS="detect_leaks=0 ${ASAN_OPTIONS:-}"
for program in Xvfb xdotool; do
    if ! command -v "$program" >/dev/null; then
        echo "$program is not installed"
        exit 77
    fi
done
rm -rf "$work"
mkdir -p "$work"
cd "$work"

give_up() {
    echo "FAILED: $*" >&2
    [ ! -s err ] || cat err >&2
    exit 1
}

# A display number that is free is chosen by the server.
Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp -noreset 3>display 2>/dev/null &
server=$!
player=
trap '[ -z "$player" ] || kill "$player" 2>/dev/null || true; kill $server 2>/dev/null || true' EXIT
for _ in $(seq 100); do
    [ -s display ] && break
    sleep 0.1
done
[ -s display ] || give_up "no display"
DISPLAY=:$(cat display)
export DISPLAY

start() {
    "$play" "$@" >out 2>err &
    player=$!
    for _ in $(seq 100); do
        window=$(xdotool search --pid "$player" --name nsdf-play 2>/dev/null | head -n 1) || true
        [ -n "$window" ] && break
        kill -0 "$player" 2>/dev/null || give_up "the player ended"
        sleep 0.1
    done
    [ -n "$window" ] || give_up "no window"
    xdotool mousemove 100 100
    sleep 1
}

# There is no window manager: keys go to the window below the pointer.
press() {
    xdotool key "$@"
    sleep 0.4
}

# Saves a picture and gives it a name.
shot() {
    rm -f nsdf-play_*.png
    press s
    for _ in $(seq 50); do
        compgen -G 'nsdf-play_*.png' >/dev/null && break
        sleep 0.1
    done
    mv nsdf-play_*.png "$1.png" || give_up "no picture: $1"
}

# Width and height, from the header of the file.
picture_size() {
    local byte
    read -r -a byte < <(od -An -tu1 -j 16 -N 8 "$1.png")
    echo "$((byte[2] * 256 + byte[3]))x$((byte[6] * 256 + byte[7]))"
}

# The first picture is there when two in a row are the same and show more than the background.
settled() {
    shot "$1"
    for _ in $(seq 30); do
        mv "$1.png" before.png
        shot "$1"
        ! cmp -s "$1.png" before.png || [ "$(stat -c %s "$1.png")" -lt 20000 ] || return 0
    done
    give_up "no settled picture"
}

# What a key does is seen some time later: pictures are saved under a name until one is other than, or the same as, one
# that is there.
until_other() {
    for _ in $(seq 30); do
        shot "$1"
        cmp -s "$1.png" "$2.png" || return 0
    done
    give_up "$1 and $2 are the same picture"
}

until_same() {
    for _ in $(seq 30); do
        shot "$1"
        ! cmp -s "$1.png" "$2.png" || return 0
    done
    give_up "$1 and $2 are different pictures"
}

finish() {
    local code=0
    xdotool key q || true
    wait "$player" || code=$?
    player=
    [ "$code" = 0 ] || give_up "exit code $code"
    [ ! -s err ] || give_up "messages"
}

# Standing: keys seek exactly, and the same place gives the same picture.
start "$file" --paused --size 640x480 --resolution 48
settled first
press Right
until_other second first
press Left
until_same again first
press End
until_other end first
press Home
until_same home first
press m
until_other flat first
press m m m
until_same shaded first
press g
until_other ghost first
press 5
until_other middle ghost

# The mouse turns and zooms the view, f fits it again; a click on the time bar seeks.
press g Home f
until_same fitted first
xdotool mousemove 320 200 mousedown 1 mousemove 420 230 mouseup 1
until_other turned fitted
xdotool click 4
until_other zoomed turned
press f
until_other refitted zoomed
xdotool mousemove 600 470 click 1
until_other sought refitted

# Another size, not to be seen for a while, help and back: it goes on.
xdotool windowsize "$window" 400 300
xdotool mousemove 100 100
until_other small sought
[ "$(picture_size small)" = 400x300 ] || give_up "a picture of $(picture_size small)"
xdotool windowunmap "$window"
sleep 0.5
xdotool windowmap "$window" mousemove 200 150
sleep 0.5
press h h m
until_other shown_again small
finish

# Closed while it decodes, at once and a little later.
for pause in 0 0.1 0.3; do
    start "$file" --resolution 512 --size 320x240
    press Right space
    sleep "$pause"
    finish
done

# Playing: punctual enough, and it ends by itself.
start "$file" --exit-after 3 --statistics --size 320x240 --resolution 24
wait "$player" || give_up "exit code $?"
player=
[ ! -s err ] || give_up "messages"
grep -q '^surfaces shown [0-9]' out || give_up "no statistics: $(cat out)"
shown=$(sed -nE 's/^surfaces shown ([0-9]+),.*/\1/p' out)
[ "$shown" -ge 5 ] || give_up "only $shown surfaces in three seconds"

# A file that is none, and none at all.
head -c 300 "$file" >broken.nsdf
code=0
"$play" broken.nsdf >out 2>err || code=$?
[ "$code" = 1 ] && [ "$(wc -l <err)" = 1 ] && grep -q broken.nsdf err || give_up "a broken file: $code"
: >err
start --size 320x240
finish

# A file is dropped on a window without one, and then one that is none: the first stays, and a message is shown.
if [ -n "$drop" ]; then
    start --paused --size 640x480 --resolution 48
    "$drop" "$window" "$file" || give_up "the window does not take a file"
    until_same dropped first
    "$drop" "$window" "$PWD/broken.nsdf" || give_up "the window does not take a broken file"
    until_same stayed dropped
    [ "$(wc -l <err)" = 1 ] && grep -q 'broken.nsdf cannot be played: ' err || give_up "no message about a broken file"
    : >err
    finish
fi
code=0
env -u DISPLAY -u WAYLAND_DISPLAY "$play" "$file" >out 2>err || code=$?
[ "$code" = 1 ] && [ "$(wc -l <err)" = 1 ] && grep -q -e --offscreen err || give_up "without a display: $code"
echo ok

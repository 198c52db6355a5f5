#!/usr/bin/env bash
# Plays a file in a window on a display of its own, works its keys and its mouse, and looks at pictures that it saves.
# usage: window.sh NSDF_PLAY FILE WORK_FOLDER
set -euo pipefail

play=$1 file=$2 work=$3
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
Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp 3>display 2>/dev/null &
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
    xdotool mousemove 320 200
    sleep 1
}

press() {
    xdotool key --window "$window" "$@"
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

differ() {
    ! cmp -s "$1.png" "$2.png" || give_up "$1 and $2 are the same picture"
}

equal() {
    cmp -s "$1.png" "$2.png" || give_up "$1 and $2 are different pictures"
}

finish() {
    local code=0
    xdotool key --window "$window" q 2>/dev/null || true # the window is gone before the key is up
    wait "$player" || code=$?
    player=
    [ "$code" = 0 ] || give_up "exit code $code"
    [ ! -s err ] || give_up "messages"
}

# Standing: keys seek exactly, and the same place gives the same picture.
start "$file" --paused --size 640x480 --resolution 48
shot first
press Right
shot second
press Left
shot again
press End
shot end
press Home
press m
shot flat
press m m m g
press 5
shot middle
equal first again
differ first second
differ first end
differ first flat
differ first middle

# The mouse turns and zooms the view, f fits it again; a click on the time bar seeks.
press g Home f
shot fitted
xdotool mousemove 320 200 mousedown 1 mousemove 420 230 mouseup 1
sleep 0.4
shot turned
differ fitted turned
xdotool click 4
sleep 0.4
shot zoomed
differ turned zoomed
press f
xdotool mousemove 600 470 click 1
sleep 0.4
shot sought
differ turned sought
finish

# Playing: punctual enough, and it ends by itself.
start "$file" --exit-after 3 --statistics --size 320x240 --resolution 24
wait "$player" || give_up "exit code $?"
player=
[ ! -s err ] || give_up "messages"
grep -q '^surfaces shown [0-9]' out || give_up "no statistics: $(cat out)"
shown=$(sed -nE 's/^surfaces shown ([0-9]+),.*/\1/p' out)
[ "$shown" -ge 20 ] || give_up "only $shown surfaces in three seconds"

# A file that is none, and none at all.
head -c 300 "$file" >broken.nsdf
code=0
"$play" broken.nsdf >out 2>err || code=$?
[ "$code" = 1 ] && [ "$(wc -l <err)" = 1 ] && grep -q broken.nsdf err || give_up "a broken file: $code"
: >err
start --size 320x240
finish
code=0
env -u DISPLAY -u WAYLAND_DISPLAY "$play" "$file" >out 2>err || code=$?
[ "$code" = 1 ] && [ "$(wc -l <err)" = 1 ] && grep -q -e --offscreen err || give_up "without a display: $code"
echo ok

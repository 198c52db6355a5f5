#!/usr/bin/env bash
# Checks who may include whom, and that the decoder library holds no writer and no encoder.
# usage: check_dependencies.sh SOURCE_ROOT [LIBRARY_FOLDER]
set -euo pipefail

root=${1:?usage: check_dependencies.sh SOURCE_ROOT [LIBRARY_FOLDER]}
libraries=${2:-}
failures=0

fail() {
    printf '%s\n' "$*" >&2
    failures=$((failures + 1))
}

# Sets `area` to that which a file belongs to; longest folder first.  (No output to capture: that is a process a line.)
area_of() {
    case $1 in
    format/*_write.[ch] | format/buffer.c | format/quantise.c) area=format-write ;;
    format/*) area=format-read ;;
    decoder/include/*) area=decoder-api ;;
    decoder/cli/*) area=cli ;;
    decoder/*) area=decoder ;;
    encoder/include/*) area=encoder-api ;;
    encoder/cli/*) area=cli-enc ;;
    encoder/*) area=encoder ;;
    player/*) area=player ;;
    samples/*) area=samples ;;
    *) area=other ;;
    esac
}

# Sets `allowed` to the areas that an area may include.
allowed_for() {
    allowed=''
    case $1 in
    format-read) allowed='format-read' ;;
    format-write) allowed='format-read format-write' ;;
    decoder-api) allowed='decoder-api' ;;
    decoder) allowed='decoder decoder-api format-read' ;;
    cli) allowed='cli decoder-api' ;;
    encoder-api) allowed='encoder-api decoder-api' ;;
    encoder) allowed='encoder encoder-api decoder-api format-read format-write' ;;
    cli-enc) allowed='cli cli-enc encoder-api decoder-api' ;;
    player) allowed='player cli decoder-api' ;;
    samples) allowed='samples decoder-api' ;;
    esac
}

cd "$root"
folders=()
for folder in format decoder encoder player samples; do
    [ -d "$folder" ] && folders+=("$folder")
done

declare -A header_area
while IFS= read -r header; do
    case $header in
    */include/*) key=${header#*/include/} ;;
    *) key=${header##*/} ;;
    esac
    if [ -n "${header_area[$key]:-}" ]; then
        fail "$header: another header has the name $key; file names are unique across the tree"
    fi
    area_of "$header"
    header_area[$key]=$area
done < <(find "${folders[@]}" -name '*.h' | LC_ALL=C sort)

checked=0
while IFS=: read -r file line text; do
    case $text in
    *'"'*) ;;
    *'<nsdf/'*) ;;
    *) continue ;;
    esac
    name=${text#*[<\"]}
    name=${name%%[>\"]*}
    key=$name
    [[ $name == nsdf/* ]] || key=${name##*/}
    area_of "$file"
    from=$area
    allowed_for "$from"
    to=${header_area[$key]:-}
    checked=$((checked + 1))
    if [ -z "$to" ]; then
        fail "$file:$line: includes \"$name\", which is not in the tree"
    elif [[ " $allowed " != *" $to "* ]]; then
        fail "$file:$line: $from may not include \"$name\" of $to"
    elif [ "$from" = player ] && [ "$to" = decoder-api ] && [ "$name" != nsdf/decoder.h ]; then
        fail "$file:$line: the player includes nsdf/decoder.h only, not \"$name\""
    fi
done < <(grep -rnE --include='*.[ch]' --include='*.cc' '^[[:space:]]*#[[:space:]]*include' "${folders[@]}")
[ "$checked" -gt 0 ] || fail "no #include found below $root: is this the source folder?"
echo "$checked includes checked"

# Symbols.  The archive may neither define nor ask for a writer or an encoder function.
if [ -n "$libraries" ] && [ -f "$libraries/libnsdf.a" ]; then
    writers='nsdf_(buffer_|quantise|minmax_|encoder_|sequence_'
    writers+='|write_(chunk|preamble|header|quality|metadata|file|network|segment))'
    symbols=$(nm "$libraries/libnsdf.a" 2>/dev/null | awk 'NF >= 2 { print $NF }' | LC_ALL=C sort -u)
    grep -q '^nsdf_open_memory$' <<<"$symbols" || fail "libnsdf.a: nsdf_open_memory is missing"
    while IFS= read -r symbol; do
        fail "libnsdf.a: holds or needs $symbol, which belongs to the encoder"
    done < <(grep -E "^$writers" <<<"$symbols" || true)
    echo "libnsdf.a checked"
fi
if [ -n "$libraries" ] && [ -f "$libraries/libnsdf.so" ]; then
    public=$(sed -E 's@/\*.*\*/@@' decoder/include/nsdf/*.h | tr '\n' ' ' | grep -oE 'NSDF_API[^;{]*\(' |
        grep -oE 'nsdf_[a-z0-9_]+ *\($' | tr -d ' (' | LC_ALL=C sort -u)
    exported=$(nm -D --defined-only "$libraries/libnsdf.so" | awk '{ print $NF }' |
        grep -vE '^(_init|_fini|_end|_edata|__bss_start|__odr_asan.*)$' | sed 's/@.*//' | LC_ALL=C sort -u)
    while IFS= read -r symbol; do
        fail "libnsdf.so: exports $symbol, which no public header declares"
    done < <(LC_ALL=C comm -13 <(echo "$public") <(echo "$exported"))
    while IFS= read -r symbol; do
        fail "libnsdf.so: $symbol is declared in a public header but not exported"
    done < <(LC_ALL=C comm -23 <(echo "$public") <(echo "$exported"))
    echo "libnsdf.so checked: $(wc -l <<<"$exported") symbols"
fi

if [ "$failures" -gt 0 ]; then
    echo "$failures dependency rules broken" >&2
    exit 1
fi

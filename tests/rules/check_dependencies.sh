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

# The area that a file belongs to; longest folder first.
area_of() {
    case $1 in
    format/*_write.[ch] | format/buffer.c | format/quantise.c) echo format-write ;;
    format/*) echo format-read ;;
    decoder/include/*) echo decoder-api ;;
    decoder/cli/*) echo cli ;;
    decoder/*) echo decoder ;;
    encoder/include/*) echo encoder-api ;;
    encoder/cli/*) echo cli-enc ;;
    encoder/*) echo encoder ;;
    player/*) echo player ;;
    samples/*) echo samples ;;
    *) echo other ;;
    esac
}

# The areas that an area may include.
allowed_for() {
    case $1 in
    format-read) echo format-read ;;
    format-write) echo format-read format-write ;;
    decoder-api) echo decoder-api ;;
    decoder) echo decoder decoder-api format-read ;;
    cli) echo cli decoder-api ;;
    encoder-api) echo encoder-api decoder-api ;;
    encoder) echo encoder encoder-api decoder-api format-read format-write ;;
    cli-enc) echo cli cli-enc encoder-api decoder-api ;;
    player) echo player cli decoder-api ;;
    samples) echo samples decoder-api ;;
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
    header_area[$key]=$(area_of "$header")
done < <(find "${folders[@]}" -name '*.h' | LC_ALL=C sort)

checked=0
while IFS=: read -r file line text; do
    name=$(sed -E 's/^[[:space:]]*#[[:space:]]*include[[:space:]]*[<"]([^>"]*)[>"].*/\1/' <<<"$text")
    case $text in
    *'"'*) ;;
    *'<nsdf/'*) ;;
    *) continue ;;
    esac
    key=$name
    [[ $name == nsdf/* ]] || key=${name##*/}
    from=$(area_of "$file")
    to=${header_area[$key]:-}
    checked=$((checked + 1))
    if [ -z "$to" ]; then
        fail "$file:$line: includes \"$name\", which is not in the tree"
    elif [[ " $(allowed_for "$from") " != *" $to "* ]]; then
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

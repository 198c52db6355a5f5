#!/usr/bin/env bash
# Checks the style limits: file length, line length, tabs, function length, and clang-format where it is installed.
# usage: check_style.sh SOURCE_ROOT
set -euo pipefail

cd "${1:?usage: check_style.sh SOURCE_ROOT}"
max_file=900 max_line=120 max_function=100
failures=0

fail() {
    printf '%s\n' "$*" >&2
    failures=$((failures + 1))
}

folders=()
for folder in format decoder encoder player samples spec tests scripts; do
    [ -d "$folder" ] && folders+=("$folder")
done
mapfile -t c_files < <(find "${folders[@]}" -name '*.[ch]' | LC_ALL=C sort)
mapfile -t all_files < <(
    printf '%s\n' "${c_files[@]}"
    find "${folders[@]}" CMakeLists.txt \( -name '*.sh' -o -name CMakeLists.txt -o -name '*.cc' \) | LC_ALL=C sort
)
[ "${#c_files[@]}" -gt 0 ] || fail "no C files found"

while read -r lines file; do
    [ "$lines" -le "$max_file" ] || fail "$file: $lines lines, more than $max_file"
done < <(wc -l "${all_files[@]}" | sed '$d')

# The first line of each file that has the pattern; a process for all files is a minute less than one for each.
forbid() {
    while IFS=: read -r file number _; do
        fail "$file:$number: $2"
    done < <(LC_ALL=C.UTF-8 grep -nHE "$1" "${all_files[@]}" | awk -F: '!seen[$1]++')
}
forbid $'\t' 'a tab'
forbid '[[:space:]]+$' 'space at the end of a line'
forbid "^.{$((max_line + 1))}" "longer than $max_line columns"

# A function runs from the line that begins at column 0 to the next closing brace at column 0.
lengths=$(awk '
    FNR == 1 { start = 0; body = 0 }
    body && /^}/ { printf "%d %s:%d %s\n", FNR - start + 1, FILENAME, start, name; body = 0; start = 0; next }
    body { next }
    /^[A-Za-z_]/ { start = FNR; name = $0 }
    start && /;[[:space:]]*$/ { start = 0 }
    start && /\)[[:space:]]*\{$/ { body = 1; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name) }
' "${c_files[@]}" | LC_ALL=C sort -n)
while read -r length where name; do
    [ "$length" -le "$max_function" ] || fail "$where: $name has $length lines, more than $max_function"
done <<<"$lengths"
awk '{ n[NR] = $1; long += $1 > 60 } END {
    if (NR) printf "%d functions: median %d lines, 90 %% within %d, longest %d, %d above 60\n",
        NR, n[int((NR + 1) / 2)], n[int(NR * 0.9)], n[NR], long }' <<<"$lengths"

# Other versions format differently.
if [ -f .clang-format ] && command -v clang-format >/dev/null && clang-format --version | grep -q 'version 14\.'; then
    mapfile -t unformatted < <(clang-format --dry-run "${c_files[@]}" 2>&1 |
        sed -nE 's/^([^:]+):[0-9]+:[0-9]+: warning.*/\1/p' | uniq)
    for file in "${unformatted[@]}"; do
        fail "$file: not as clang-format writes it"
    done
else
    echo "clang-format 14 is not installed: layout not checked"
fi

if [ "$failures" -gt 0 ]; then
    echo "$failures style rules broken" >&2
    exit 1
fi
echo "${#all_files[@]} files follow the style limits"

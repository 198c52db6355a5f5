#!/usr/bin/env bash
# Every public function of the decoder is on the API page, and every function on that page exists.
# usage: check_api_page.sh SOURCE_ROOT
set -euo pipefail

cd "${1:?usage: check_api_page.sh SOURCE_ROOT}"
declared=$(sed -E 's@/\*.*\*/@@' decoder/include/nsdf/*.h | tr '\n' ' ' | grep -oE 'NSDF_API[^;{]*\(' |
    grep -oE 'nsdf_[a-z0-9_]+ *\($' | tr -d ' (' | LC_ALL=C sort -u)
described=$(grep -oE '`nsdf_[a-z0-9_]+`' docs/api.md | tr -d '`' | grep -vE '^nsdf_error$' | LC_ALL=C sort -u)
if ! difference=$(diff <(echo "$declared") <(echo "$described")); then
    echo "docs/api.md (>) and the headers (<) differ:" >&2
    echo "$difference" >&2
    exit 1
fi
echo "$(wc -l <<<"$declared") functions"

#!/usr/bin/env bash
# Runs command-line cases and compares what they print with what is expected.
# usage: run_cli.sh [--bless] --bin FOLDER --fixture FOLDER [CASE...]
#   --bin       where nsdf-enc, nsdf-dec and nsdf-sample are
#   --fixture   what make_fixture.sh made
#   --bless     write the expectations anew from what the commands print now; look at the difference before committing
#   CASE        names of cases, all by default
#
# A case is cases/NAME.sh, run by bash in an empty folder in which `fixture` leads to the fixture, with lib.sh loaded
# and the commands in the PATH.  Beside it, each only where it is not empty (or 0):
#   NAME.stdout, NAME.stderr             the exact output
#   NAME.stdout.glob, NAME.stderr.glob   a bash pattern that the whole output must match; --bless leaves these alone
#   NAME.exit                            the exit code
# A case that ends with exit code 77 is skipped.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bless=0 bin='' fixture=''
names=()
while [ $# -gt 0 ]; do
    case $1 in
    --bless) bless=1 ;;
    --bin) bin=${2:?--bin needs a folder} && shift ;;
    --fixture) fixture=${2:?--fixture needs a folder} && shift ;;
    -*) echo "run_cli.sh: unknown option $1" >&2 && exit 2 ;;
    *) names+=("$1") ;;
    esac
    shift
done
if [ -z "$bin" ] || [ -z "$fixture" ]; then
    sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
bin=$(cd "$bin" && pwd)
fixture=$(cd "$fixture" && pwd)
if [ "${#names[@]}" -eq 0 ]; then
    for script in "$here"/cases/*.sh; do
        names+=("$(basename "$script" .sh)")
    done
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# compare NAME STREAM ACTUAL: 0 when the stream is as expected; a blessed exact file always is.
compare() {
    local expected=$here/cases/$1.$2 actual=$3
    if [ -f "$expected.glob" ]; then
        # The pattern is meant to be one.
        # shellcheck disable=SC2053
        [[ $(<"$actual") == $(<"$expected.glob") ]] && return 0
        echo "--- $1: $2 does not match $expected.glob:"
        sed 's/^/    /' "$actual"
        return 1
    fi
    if [ "$bless" = 1 ]; then
        if [ -s "$actual" ]; then cp "$actual" "$expected"; else rm -f "$expected"; fi
        return 0
    fi
    [ -f "$expected" ] || expected=/dev/null
    cmp -s "$expected" "$actual" && return 0
    echo "--- $1: $2 differs (-expected +found):"
    diff -u "$expected" "$actual" | tail -n +3 | head -n 60
    return 1
}

# 0 passed, 1 failed, 77 skipped
run_case() {
    local name=$1 code=0 wanted=0 bad=0 exit_file=$here/cases/$1.exit
    local scratch=$work/$name
    mkdir -p "$scratch/run"
    ln -s "$fixture" "$scratch/run/fixture"
    (
        cd "$scratch/run"
        PATH="$bin:$PATH" LC_ALL=C bash -euo pipefail -c 'source "$1"; source "$2"' case "$here/lib.sh" \
            "$here/cases/$name.sh" </dev/null >"$scratch/stdout" 2>"$scratch/stderr"
    ) || code=$?
    if [ "$code" = 77 ]; then
        echo "$name: skipped: $(head -n 1 "$scratch/stderr")"
        return 77
    fi
    if [ "$bless" = 1 ]; then
        if [ "$code" = 0 ]; then rm -f "$exit_file"; else echo "$code" >"$exit_file"; fi
    fi
    [ -f "$exit_file" ] && wanted=$(<"$exit_file")
    if [ "$code" != "$wanted" ]; then
        echo "--- $name: exit code $code, expected $wanted"
        bad=1
    fi
    compare "$name" stdout "$scratch/stdout" || bad=1
    compare "$name" stderr "$scratch/stderr" || bad=1
    rm -rf "$scratch"
    return "$bad"
}

passed=0 failed=0 skipped=0
for name in "${names[@]}"; do
    if [ ! -f "$here/cases/$name.sh" ]; then
        echo "run_cli.sh: there is no case $name" >&2
        exit 2
    fi
    result=0
    run_case "$name" || result=$?
    case $result in
    0) passed=$((passed + 1)) ;;
    77) skipped=$((skipped + 1)) ;;
    *) failed=$((failed + 1)) ;;
    esac
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] || exit 1
# A single skipped case is told to ctest as such.
[ "$passed" -gt 0 ] || exit 77

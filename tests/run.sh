#!/bin/sh
# run.sh TEST...: runs each test, shows its last line (all of its output if it fails), and closes with the sum of all counts.
set -u
passed=0 failed=0 skipped=0
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
for test in "$@"; do
    case $test in
    *.sh) sh "$test" >"$log" 2>&1 ;;
    *) "$test" >"$log" 2>&1 ;;
    esac
    status=$?
    line=$(tail -n 1 "$log")
    p=$(printf '%s\n' "$line" | sed -n 's/^.*: \([0-9][0-9]*\) passed, .*/\1/p')
    f=$(printf '%s\n' "$line" | sed -n 's/^.*passed, \([0-9][0-9]*\) failed.*/\1/p')
    s=$(printf '%s\n' "$line" | sed -n 's/^.*failed, \([0-9][0-9]*\) skipped.*/\1/p')
    # a test that ends without its line, or badly in spite of it, has failed
    if [ -z "$p" ] || [ -z "$f" ] || { [ "$status" -ne 0 ] && [ "$f" -eq 0 ]; } ||
        [ "$((${p:-0} + ${f:-0} + ${s:-0}))" -eq 0 ]; then
        line="$test: ended with status $status"
        f=$((${f:-0} + 1))
    fi
    if [ "$f" -gt 0 ]; then tail -n 60 "$log"; fi
    printf '%s\n' "$line"
    passed=$((passed + ${p:-0})) failed=$((failed + f)) skipped=$((skipped + ${s:-0}))
done
printf '%d passed, %d failed, %d skipped\n' "$passed" "$failed" "$skipped"
[ "$failed" -eq 0 ]

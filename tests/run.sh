#!/bin/sh
# run.sh TEST...: runs the tests, as many at a time as there are processors; shows the last line of each that ends (all of its
# output if it fails), and closes with the sum of all counts.
# run.sh --one TEST: runs one and appends its counts to the file $COUNTS.
set -u

# one TEST
one() {
    log=$(mktemp) || exit 1
    case $1 in
    *.sh) sh "$1" >"$log" 2>&1 ;;
    *) "$1" >"$log" 2>&1 ;;
    esac
    status=$?
    line=$(tail -n 1 "$log")
    p=$(printf '%s\n' "$line" | sed -n 's/^.*: \([0-9][0-9]*\) passed, .*/\1/p')
    f=$(printf '%s\n' "$line" | sed -n 's/^.*passed, \([0-9][0-9]*\) failed.*/\1/p')
    s=$(printf '%s\n' "$line" | sed -n 's/^.*failed, \([0-9][0-9]*\) skipped.*/\1/p')
    # a test that ends without its line, or badly in spite of it, has failed
    if [ -z "$p" ] || [ -z "$f" ] || { [ "$status" -ne 0 ] && [ "$f" -eq 0 ]; } ||
        [ "$((${p:-0} + ${f:-0} + ${s:-0}))" -eq 0 ]; then
        line="$1: ended with status $status"
        f=$((${f:-0} + 1))
    fi
    # in one piece, whatever else ends at the same time
    if [ "$f" -gt 0 ]; then line="$(tail -n 60 "$log")
$line"; fi
    printf '%s\n' "$line"
    printf '%d %d %d\n' "${p:-0}" "$f" "${s:-0}" >>"$COUNTS"
    rm -f "$log"
}

if [ "${1:-}" = --one ]; then
    one "$2"
    exit
fi
COUNTS=$(mktemp) || exit 1
export COUNTS
trap 'rm -f "$COUNTS"' EXIT
printf '%s\n' "$@" | xargs -P "$(nproc)" -n 1 sh "$0" --one
awk -v wanted="$#" '
    { passed += $1; failed += $2; skipped += $3 }
    END { failed += wanted - NR # one that left no counts has failed
          printf "%.0f passed, %.0f failed, %.0f skipped\n", passed, failed, skipped
          exit failed > 0 }' "$COUNTS"

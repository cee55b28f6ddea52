#!/bin/sh
# Tables in the source are what their scripts print.
. tests/cli/lib.sh

# numbers: of the text on standard input, behind the brace that begins the table, one a line
numbers() {
    tr -d '\n' | sed 's/^.*= {//' | tr -cs '0-9' '\n' | grep .
}

if command -v python3 >/dev/null; then
    python3 tests/oracle/derive_blue.py >"$work/blue.c" || fail 'derive_blue.py'
    numbers <"$work/blue.c" >"$work/derived"
    numbers <src/kernel/blue.c >"$work/stored"
    check 'blue noise has 4096 ranks' test "$(sort -n -u "$work/stored" | wc -l)" -eq 4096
    check 'blue noise is what derive_blue.py makes' cmp -s "$work/derived" "$work/stored"
else
    skip 'there is no python3'
fi

finish test_tables

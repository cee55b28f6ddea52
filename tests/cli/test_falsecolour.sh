#!/bin/sh
# False colour on the command line. Its pixels are compared with long double in tests/oracle/test_falsecolour.c.
. tests/cli/lib.sh

room=testdata/interior_float.exr other=$work/other.exr
"$hdr" expose --ev 0.1 -o "$other" "$room"

# ---- diff --false-colour ----------------------------------------------------------------------------------------

for kind in signed absolute relative squared smape; do
    expect_status 0 "diff --kind $kind" "$hdr" diff --kind "$kind" --false-colour magma -o "$work/short.png" "$room" "$other"
    "$hdr" diff --kind "$kind" : falsecolour --of largest --map magma -o "$work/long.png" "$room" "$other"
    check "diff --kind $kind --false-colour is short for a clause" cmp -s "$work/short.png" "$work/long.png"
done
"$hdr" diff --false-colour none -o "$work/none.exr" "$room" "$other"
"$hdr" diff -o "$work/plain.exr" "$room" "$other"
check 'diff --false-colour none: none' cmp -s "$work/none.exr" "$work/plain.exr"
"$hdr" diff --false-colour viridis : exr --record -o "$work/recorded.exr" "$room" "$other"
"$hdr" info "$work/recorded.exr" >"$work/stdout"
check 'it is recorded as that clause, once' test "$(grep -o 'falsecolour' "$work/stdout" | wc -l)" -eq 1
check 'and not as the option' test "$(grep -c 'false-colour' "$work/stdout")" -eq 0
expect_status 64 'a map that is none' "$hdr" diff --false-colour blue -o "$work/x.png" "$room" "$other"
expect_status 64 'given twice' "$hdr" diff --false-colour magma --false-colour viridis -o "$work/x.png" "$room" "$other"
expect_status 65 'then encoded' "$hdr" diff --false-colour magma : srgb -o "$work/x.png" "$room" "$other"

# ---- The legend --------------------------------------------------------------------------------------------------

# height FILE: of a PNG
height() { od -An -j20 -N4 -tu1 "$1" | awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 }'; }

"$hdr" png -q -o "$work/size.png" "$room"
"$hdr" falsecolour -o "$work/legend.png" "$room"
"$hdr" falsecolour --no-legend -o "$work/bare.png" "$room"
check 'a legend below' test "$(height "$work/legend.png")" -gt "$(height "$work/size.png")"
check '--no-legend: none' test "$(height "$work/bare.png")" -eq "$(height "$work/size.png")"
for words in -j1 -j3 --reference --no-skip --memory=1M; do
    "$hdr" falsecolour "$words" -o "$work/again.png" "$room"
    check "falsecolour $words: the same bytes" cmp -s "$work/legend.png" "$work/again.png"
done
"$hdr" falsecolour <"$room" | "$hdr" png >"$work/pipe.png"
check 'falsecolour through a pipe: the same bytes' cmp -s "$work/legend.png" "$work/pipe.png"
"$hdr" falsecolour -o "$work/colours.exr" "$room"
"$hdr" info --json "$work/colours.exr" >"$work/stdout"
check 'EXR has no legend' grep -q '"height": 120' "$work/stdout"
check 'and is encoded' grep -q '"state": "srgb"' "$work/stdout"
"$hdr" png -o "$work/twice.png" "$work/colours.exr"
check 'the same colours by way of EXR' cmp -s "$work/twice.png" "$work/bare.png"
"$hdr" falsecolour --explain -o "$work/x.png" "$room" 2>"$work/stderr"
check '--explain tells the range' grep -q 'viridis of luminance from 0 to [1-9]' "$work/stderr"

# ---- Words that make no command ----------------------------------------------------------------------------------

expect_status 64 'from above to' "$hdr" falsecolour --from 2 --to 1 -o "$work/x2.png" "$room"
expect_status 64 'from is to' "$hdr" falsecolour --from 1 --to 1 -o "$work/x2.png" "$room"
expect_status 64 'a logarithm of 0' "$hdr" falsecolour --scale log --from 0 -o "$work/x2.png" "$room"
expect_status 64 'a logarithm of less' "$hdr" falsecolour --scale log --to -1 -o "$work/x2.png" "$room"
expect_status 64 'a logarithm of nearly 0' "$hdr" falsecolour --scale log --to 1e-320 -o "$work/x2.png" "$room"
expect_status 64 'a logarithm that parts at 0' "$hdr" falsecolour --scale log --map coolwarm -o "$work/x2.png" "$room"
expect_status 64 'a percentile of nothing' "$hdr" falsecolour --percentile 99 --from 0 --to 1 -o "$work/x2.png" "$room"
expect_status 65 'codes twice' "$hdr" falsecolour : srgb -o "$work/x2.png" "$room"
check 'nothing is written' absent "$work/x2.png"

finish test_falsecolour

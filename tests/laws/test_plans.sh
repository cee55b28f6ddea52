#!/bin/sh
# What a plan decides must not show in the pixels: skips across a conversion of primaries, ranges carried along, encoded files of other primaries,
# facts of values far below float's range. Each case once went wrong.
. tests/cli/lib.sh
hdr=$BUILD/hdr
foreign=testdata/tiny/foreign.exr

# same_pixels WHAT FILE CHAIN...: with --no-skip, with --reference and as it comes, the same floats
same_pixels() {
    what=$1 file=$2
    shift 2
    for how in plain --no-skip --reference; do
        option=
        if [ "$how" != plain ]; then option=$how; fi
        # shellcheck disable=SC2086
        "$hdr" "$@" : pfm $option -q -o "$work/$how.pfm" "$file" || fail "$what: $how"
    done
    check "$what: --no-skip" cmp "$work/plain.pfm" "$work/--no-skip.pfm"
    check "$what: --reference" cmp "$work/plain.pfm" "$work/--reference.pfm"
}

for verb in divmax clamp "expose --ev 0" "gamma -g 1" srgb quantise; do
    # shellcheck disable=SC2086
    same_pixels "divmax, $verb, clamp in other primaries" "$foreign" divmax : $verb : clamp
    # shellcheck disable=SC2086
    same_pixels "divmax, $verb, clamp to +-1 in other primaries" "$foreign" divmax : $verb : clamp --min -1 --max 1 : expose --ev -2
done
same_pixels 'gamma 1 is no identity where the conversion gives negative values' "$foreign" divmax : gamma -g 1
check 'and they are 0 then' test "$(od -An -tf4 -v "$work/plain.pfm" | tr -s ' ' '\n' | grep -c '^-')" -eq 0
same_pixels 'a range beyond the largest float' "$foreign" divmax : expose --ev 200 : expose --ev -100 : clamp --min 1e10 --max 1e31

# a grey picture of other primaries: facts behind their conversion are those of all three channels
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nPRIMARIES= 0.7347 0.2653 0 1 0.0001 -0.077 0.3 0.3\n\n-Y 2 +X 2\n'
    printf '\200\200\200\201\100\100\100\201\200\200\200\200\140\140\140\201'; } >"$work/grey.hdr"
for verb in divmax "log --per-channel" "expose --auto"; do
    # shellcheck disable=SC2086
    same_pixels "log, srgb, $verb of grey in other primaries" "$work/grey.hdr" log : srgb : $verb
done
"$hdr" log : srgb : divmax : pfm -q -o "$work/a.pfm" "$work/grey.hdr"
check 'its largest component is 1 then' test "$(tail -c 48 "$work/a.pfm" | od -An -tf4 -w4 -v | sort -g | tail -n 1 | tr -d ' ')" = 1

# an encoded file of other primaries is converted when it is decoded and encoded again
"$hdr" srgb --primaries keep -o "$work/encoded.exr" "$foreign" || fail 'encode in other primaries'
"$hdr" srgb --decode : srgb : pfm -o "$work/again.pfm" "$work/encoded.exr" || fail 'decode and encode'
"$hdr" srgb : pfm -o "$work/direct.pfm" "$foreign" || fail 'encode'
# by way of float32 the values differ in their last digits: compare four
od -An -tf4 -v -w4 -j 12 "$work/again.pfm" | awk '{printf "%.4f\n", $1}' >"$work/again"
od -An -tf4 -v -w4 -j 12 "$work/direct.pfm" | awk '{printf "%.4f\n", $1}' >"$work/direct"
check 'decoding and encoding converts the primaries' cmp "$work/again" "$work/direct"

# values 10^270 times below the smallest float count as 0, and stay black
tiny="expose --ev -300 : expose --ev -300 : expose --ev -300 : expose --ev -140"
for verb in "expose --auto" log exp divmax "log --mode range"; do
    # shellcheck disable=SC2086
    same_pixels "$verb far below float's range" testdata/tiny/primaries.exr $tiny : $verb
    check "$verb far below float's range is black" test "$(od -An -tx1 -v -j 12 "$work/plain.pfm" | tr -d ' 0\n' | wc -c)" -eq 0
done

# what does not matter to a format does not make its sweep begin again
"$hdr" exr --explain -o "$work/a.exr" testdata/interior.exr 2>"$work/words" || fail 'exr'
check 'EXR does not ask whether a picture is grey' test "$(grep -c again "$work/words")" -eq 0

# the ending counts in either case
"$hdr" log testdata/glossy.exr >"$work/a.PNG" || fail 'a.PNG'
check 'standard output in a.PNG is a PNG' test "$(od -An -tx1 -N4 "$work/a.PNG" | tr -d ' ')" = 89504e47

# a line of the head is as strict as a command line
head_of() { printf 'hdrpipe 1\n%s\nthen clamp\n\n' "$1" | cat - testdata/glossy.exr >"$work/headed"; }
head_of 'read --window=data'
expect_status 0 'a reading option with =' "$hdr" png -o "$work/b.png" "$work/headed"
head_of 'read --window data --window data'
expect_status 65 'a reading option twice' "$hdr" png -o "$work/b.png" "$work/headed"
head_of 'read --strict --strict'
expect_status 65 'a flag twice' "$hdr" png -o "$work/b.png" "$work/headed"

finish test_plans

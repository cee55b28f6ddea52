#!/bin/sh
# hdr smooth on the command line: what it makes of renders of the path tracer in testdata, against one that took 16
# times as many samples as all together; how it goes through pipes; what is refused.
# shellcheck disable=SC1010 # `then` is a word of hdr's here
. tests/cli/lib.sh

render() { # SCENE SEED SAMPLES OUT
    "$BUILD/testdata/render" "$1" --width 96 --height 72 --samples "$3" --seed "$2" --type float --compression zip \
        --threads 1 -o "$4"
}

# renders SCENE SAMPLES: eight independent ones, their mean, its deviation, and what is made of them
renders() {
    seed=1
    while [ "$seed" -le 8 ]; do
        render "$1" "$seed" "$2" "$work/r$seed.exr" || break
        seed=$((seed + 1))
    done
    "$hdr" mean -o "$work/mean.exr" "$work"/r?.exr
    "$hdr" mean --show mean-deviation -o "$work/sigma.exr" "$work"/r?.exr
    expect_status 0 "$1" "$hdr" smooth --sigma-picture "$work/sigma.exr" --explain -o "$work/smooth.exr" "$work/mean.exr"
}

# figure NAME PICTURE: against the reference
figure() {
    "$hdr" error --json --against "$work/reference.exr" "$2" | grep -o "\"$1\": [^,}]*" | head -n 1 | sed 's/.*: //'
}

# at_most A PART B: A is at most that part of B
at_most() { awk -v a="$1" -v part="$2" -v b="$3" 'BEGIN { exit !(a != "" && b > 0 && a <= part * b) }'; }

# ---- Against a reference -----------------------------------------------------------------------------------------

# much noise: less than half of the relative squared error is left, two thirds of the relative one
render interior 9999 512 "$work/reference.exr"
renders interior 4
check 'it says that it is biased' stderr_has biased
check 'it says how many pixels were left alone' grep -q 'smooth: [0-9]* of 6912 pixels .* left alone' "$work/stderr"
for limit in mrse:0.5 smape:0.67 rmse:1; do
    name=${limit%:*} part=${limit#*:}
    check "noisy: $name falls to $part of what it was" \
        at_most "$(figure "$name" "$work/smooth.exr")" "$part" "$(figure "$name" "$work/mean.exr")"
done
cp "$work/mean.exr" "$work/noisy.exr"
cp "$work/sigma.exr" "$work/noisy_sigma.exr"
cp "$work/smooth.exr" "$work/noisy_smooth.exr"
mkdir "$work/noisy"
cp "$work"/r?.exr "$work/noisy"

# little noise: most pixels have none, and nothing gets worse
render object 9999 512 "$work/reference.exr"
renders object 4
alone=$(sed -n 's/^smooth: \([0-9]*\) of 6912 .*/\1/p' "$work/stderr")
check "little noise: most pixels are left alone ($alone of 6912)" test "${alone:-0}" -gt 3456
for name in mrse smape rmse; do
    check "little noise: $name does not rise" \
        at_most "$(figure "$name" "$work/smooth.exr")" 1 "$(figure "$name" "$work/mean.exr")"
    check "little noise: $name falls by less than a fifth" \
        at_most "$(figure "$name" "$work/mean.exr")" 1.25 "$(figure "$name" "$work/smooth.exr")"
done
"$hdr" smooth --sigma-picture "$work/sigma.exr" --above 1e6 -o "$work/above.exr" "$work/mean.exr"
"$hdr" exr -o "$work/plain.exr" "$work/mean.exr"
"$hdr" pfm -q -o "$work/a.pfm" "$work/above.exr"
"$hdr" pfm -q -o "$work/b.pfm" "$work/plain.exr"
check '--above 1e6 leaves all alone' cmp -s "$work/a.pfm" "$work/b.pfm"

# ---- The same bytes ----------------------------------------------------------------------------------------------

picture=$work/noisy.exr sigma=$work/noisy_sigma.exr
for cpu in c sse2 avx2 avx512; do
    HDR_CPU=$cpu "$hdr" smooth --sigma-picture "$sigma" -j 3 -o "$work/x.exr" "$picture"
    check "HDR_CPU=$cpu" cmp -s "$work/x.exr" "$work/noisy_smooth.exr"
done
"$hdr" smooth --sigma-picture "$sigma" -o "$work/x.exr" <"$picture"
check 'from standard input' cmp -s "$work/x.exr" "$work/noisy_smooth.exr"
"$hdr" mean then smooth --sigma-picture "$sigma" then pfm -o "$work/x.pfm" "$work/noisy"/r?.exr
"$hdr" pfm -o "$work/y.pfm" "$work/noisy_smooth.exr"
check 'behind mean' cmp -s "$work/x.pfm" "$work/y.pfm"
"$hdr" mean "$work/noisy"/r?.exr | "$hdr" smooth --sigma-picture "$sigma" | cat >"$work/x.exr"
check 'in a pipe it makes EXR' cmp -s "$work/x.exr" "$work/noisy_smooth.exr"
"$hdr" smooth --sigma-picture "$sigma" then reinhard then pfm -o "$work/x.pfm" "$picture"
"$hdr" smooth --sigma-picture "$sigma" "$picture" | "$hdr" reinhard | "$hdr" pfm >"$work/y.pfm"
check 'a pipe and then' cmp -s "$work/x.pfm" "$work/y.pfm"
# a crop is a picture of its own: what lies outside has no part in it
for file in "$picture" "$sigma"; do
    "$hdr" exr --crop 5,7,30,20 --window data -o "$work/crop_$(basename "$file")" "$file"
done
"$hdr" smooth --crop 5,7,30,20 --sigma-picture "$sigma" then pfm -o "$work/x.pfm" "$picture"
"$hdr" smooth --sigma-picture "$work/crop_noisy_sigma.exr" then pfm -o "$work/y.pfm" "$work/crop_noisy.exr"
check '--crop holds for both' cmp -s "$work/x.pfm" "$work/y.pfm"
# Rows are worked on by the filter's tiles, not by the file's chunks, which tells where numbers are so
# large (one pixel of 2^127) that the noise beside them underflows
"$hdr" pfm -q -o "$work/large.pfm" "$picture"
printf '\000\000\000\177' | dd of="$work/large.pfm" bs=1 conv=notrunc \
    seek=$(($(wc -c <"$work/large.pfm") - 25 * 96 * 12 - 48 * 12)) 2>/dev/null
"$hdr" exr -o "$work/large.exr" "$work/large.pfm"
for file in "$work/large.exr" "$sigma"; do
    "$hdr" exr --crop 0,5,96,67 --window data -o "$work/crop_$(basename "$file")" "$file"
done
"$hdr" smooth --crop 0,5,96,67 --sigma-picture "$sigma" then pfm -o "$work/x.pfm" "$work/large.exr"
"$hdr" smooth --sigma-picture "$work/crop_noisy_sigma.exr" then pfm -o "$work/y.pfm" "$work/crop_large.exr"
check 'the same bytes however the file is cut' cmp -s "$work/x.pfm" "$work/y.pfm"
# alpha has no deviation, and stays
"$hdr" mean --show deviation -o "$work/x.exr" testdata/tiny/alpha.exr testdata/tiny/alpha.exr
expect_status 0 'a picture with alpha' "$hdr" smooth --sigma-picture "$work/x.exr" -o "$work/y.exr" testdata/tiny/alpha.exr
"$hdr" exr --type float -o "$work/z.exr" testdata/tiny/alpha.exr
expect_status 0 'and it stays' "$hdr" error --against "$work/z.exr" --threshold rmse=0 "$work/y.exr"
check 'alpha is there' test "$("$hdr" info "$work/y.exr" | grep -c '^  channels .*A float')" -eq 1

# ---- What is refused ---------------------------------------------------------------------------------------------

# refuse STATUS NAME TEXT WORD...: one line with the text (an option's help behind it), nothing written
refuse() {
    refused=$1 what=$2 text=$3
    shift 3
    expect_status "$refused" "$what" "$hdr" "$@" -o "$work/none.exr"
    check "$what: $(head -n 1 "$work/stderr")" stderr_has "$text"
    check "$what: nothing is written" absent "$work/none.exr"
}

refuse 64 'without --sigma-picture' '--sigma-picture is missing' smooth "$picture"
refuse 64 'no name' 'names no file' smooth --sigma-picture= "$picture"
refuse 64 'standard input as the deviation' 'names no file' smooth --sigma-picture - "$picture"
refuse 64 'the picture itself' 'is the picture itself' smooth --sigma-picture "$picture" "$picture"
ln "$picture" "$work/other_name.exr"
refuse 64 'the picture by another name' 'is the picture itself' smooth --sigma-picture "$work/other_name.exr" "$picture"
refuse 64 'one of the renders' 'is the picture itself' mean then smooth --sigma-picture "$work/r1.exr" "$work/r1.exr" "$work/r2.exr"
refuse 66 'a deviation that is not there' 'missing.exr' smooth --sigma-picture "$work/missing.exr" "$picture"
check 'a deviation that is not there: it alone is named' test "$(grep -c noisy.exr "$work/stderr")" -eq 0
refuse 66 'a picture that is not there' 'missing.exr' smooth --sigma-picture "$sigma" "$work/missing.exr"
refuse 65 'other sizes' 'not of one form' smooth --sigma-picture testdata/glossy.exr "$picture"
check 'other sizes: one line' one_line_with 'not of one form'
"$hdr" exr -o "$work/grey.exr" --channel R "$sigma"
refuse 65 'one channel for three' 'only' smooth --sigma-picture "$work/grey.exr" "$picture"
"$hdr" srgb -o "$work/encoded.exr" "$sigma"
refuse 65 'an encoded deviation' 'srgb' smooth --sigma-picture "$work/encoded.exr" "$picture"
"$hdr" diff -o "$work/signed.exr" "$work/r1.exr" "$work/r2.exr"
refuse 65 'a negative deviation' 'negative numbers' smooth --sigma-picture "$work/signed.exr" "$picture"
printf 'no picture' >"$work/no_picture"
refuse 65 'no picture' 'not a picture' smooth --sigma-picture "$work/no_picture" "$picture"
for verb in $(verbs_of_kind filter); do
    refuse 64 "behind $verb" "cannot come before it" "$verb" then smooth --sigma-picture "$sigma" "$picture"
done
"$hdr" expose "$picture" | "$hdr" smooth --sigma-picture "$sigma" -o "$work/none.exr" 2>"$work/stderr"
check 'behind expose in a pipe' stderr_has 'cannot come before it'
check 'behind expose in a pipe: nothing is written' absent "$work/none.exr"
refuse 64 'behind itself' 'cannot come before it' smooth --sigma-picture "$sigma" then smooth --sigma-picture "$sigma" "$picture"
refuse 64 'in front of mean' 'nothing can come before it' smooth --sigma-picture "$sigma" then mean "$picture"
refuse 64 'two pictures' 'one file too many' smooth --sigma-picture "$sigma" "$picture" "$picture"
for option in strength=0 strength=11 radius=0 radius=51 radius=1.5 patch=-1 patch=11 above=-1; do
    refuse 64 "--$option" "${option%=*}" smooth --sigma-picture "$sigma" "--$option" "$picture"
done

# a head cannot name a file of somebody else's
{ printf 'hdrpipe 1\nthen smooth --sigma-picture %s\n\n' "$sigma" && cat "$picture"; } >"$work/headed"
refuse 65 'in a head' 'smooth' exr "$work/headed"

# deviations that are no numbers: counted, and an error where that is asked for
printf 'PF\n2 1\n-1\n' >"$work/two.pfm"
printf '\000\000\200\077\000\000\200\077\000\000\200\077\000\000\000\100\000\000\200\077\000\000\200\077' >>"$work/two.pfm"
printf 'PF\n2 1\n-1\n' >"$work/nan.pfm"
printf '\000\000\300\177\000\000\200\177\000\000\200\077\000\000\000\077\000\000\000\077\000\000\000\077' >>"$work/nan.pfm"
expect_status 0 'NaN and Inf' "$hdr" smooth --sigma-picture "$work/nan.pfm" -o "$work/x.exr" "$work/two.pfm"
check 'NaN and Inf: counted' one_line_with '(now 0): 2'
refuse 65 'NaN and Inf with --strict' '2 standard deviations' smooth --strict --sigma-picture "$work/nan.pfm" "$work/two.pfm"

finish test_smooth

#!/bin/sh
# Several pictures at once on the command line: mean, diff and error. What they compute is compared with long double in
# tests/oracle/test_measure.c.
. tests/cli/lib.sh

room=testdata/interior_float.exr other=testdata/glossy.exr
"$hdr" expose --ev 1 -o "$work/twice.exr" "$room"
"$hdr" expose --ev -1 -o "$work/half.exr" "$room"

# figure NAME FILE: a number of the JSON there
figure() {
    grep -o "\"$1\": [^,}]*" "$2" | head -n 1 | sed 's/.*: //'
}

# nearly A B: to six digits
nearly() {
    awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && b != "" && (a - b) ^ 2 <= (1e-6 * b) ^ 2) }'
}

# ---- mean --------------------------------------------------------------------------------------------------------

expect_status 0 'mean of one' "$hdr" mean -o "$work/one.exr" "$room"
"$hdr" error --json --against "$room" "$work/one.exr" >"$work/json"
check 'mean of one: the picture itself' test "$(figure rmse "$work/json")" = 0
expect_status 0 'mean of three' "$hdr" mean -o "$work/mean.exr" "$work/half.exr" "$work/twice.exr" "$room"
check 'mean of three: nothing to say' stderr_lines 0
# (0.5 + 2 + 1) / 3
"$hdr" expose --ev 0.22239242133644788 -o "$work/wanted.exr" "$room"
"$hdr" error --json --against "$work/wanted.exr" "$work/mean.exr" >"$work/json"
check 'mean of three: 7/6 of the picture' awk -v e="$(figure smape "$work/json")" 'BEGIN { exit !(e != "" && e < 1e-6) }'
for option in -j1 -j3 --memory=1M; do
    expect_status 0 "mean $option" "$hdr" mean "$option" -o "$work/again.exr" "$work/half.exr" "$work/twice.exr" "$room"
    check "mean $option: the same bytes" cmp -s "$work/mean.exr" "$work/again.exr"
done
# renders that are stored in other ways, whose blocks begin elsewhere; and less than all of them
for compression in none zips zip piz pxr24; do
    "$hdr" exr --compression "$compression" -o "$work/$compression.exr" testdata/interior.exr
done
for words in '' '--crop 10,20,100,77' '--crop 390,290,50,50' '--window data' --reference --no-skip; do
    # shellcheck disable=SC2086 # words, or none
    "$hdr" mean $words : pfm -o "$work/all.pfm" "$work/none.exr" "$work/zip.exr" testdata/interior.exr "$work/piz.exr" "$work/zips.exr"
    # shellcheck disable=SC2086 # words, or none
    "$hdr" exr $words -o "$work/self.exr" testdata/interior.exr && "$hdr" pfm -o "$work/self.pfm" "$work/self.exr"
    check "mean of what is stored otherwise, $words" cmp -s "$work/all.pfm" "$work/self.pfm"
done
# tiles, of which some columns are joined at a time, across more than there are: alike, and of several sizes
wide() { # SEED
    "$BUILD/testdata/render" interior --width 2600 --height 30 --samples 1 --seed "$1" --type half --compression zip \
        --threads 1 -o "$work/wide$1.exr"
}
tiled() { # SEED NAME WIDTH HEIGHT COMPRESSION
    exrmaketiled -t "$3" "$4" -z "$5" "$work/wide$1.exr" "$work/tiled$1$2.exr"
}
for seed in 1 2 3; do
    wide "$seed"
done
"$hdr" mean : pfm -o "$work/wide.pfm" "$work/wide1.exr" "$work/wide2.exr" "$work/wide3.exr"
"$hdr" diff : pfm -o "$work/wide_diff.pfm" "$work/wide1.exr" "$work/wide2.exr"
if command -v exrmaketiled >/dev/null; then
    for seed in 1 2 3; do
        tiled "$seed" small 48 8 zip && tiled "$seed" large 700 1000 piz
    done
    for size in small large; do
        "$hdr" mean : pfm -o "$work/all.pfm" "$work/tiled1$size.exr" "$work/tiled2$size.exr" "$work/tiled3$size.exr"
        check "mean of $size tiles" cmp -s "$work/wide.pfm" "$work/all.pfm"
        "$hdr" diff : pfm -o "$work/all.pfm" "$work/tiled1$size.exr" "$work/tiled2$size.exr"
        check "diff of $size tiles" cmp -s "$work/wide_diff.pfm" "$work/all.pfm"
    done
    for words in '' '--crop 1000,3,900,20' '--crop 40,8,2000,8'; do
        # shellcheck disable=SC2086 # words, or none
        "$hdr" mean $words : pfm -o "$work/wide.pfm" "$work/wide1.exr" "$work/wide2.exr" "$work/wide3.exr"
        # shellcheck disable=SC2086 # words, or none
        "$hdr" mean $words : pfm -o "$work/all.pfm" "$work/tiled1small.exr" "$work/tiled2large.exr" "$work/wide3.exr"
        check "mean of tiles of several sizes and lines, $words" cmp -s "$work/wide.pfm" "$work/all.pfm"
    done
else
    skip 'there is no exrmaketiled'
fi
# a chain behind it, in one process and through a pipe
expect_status 0 'mean then' "$hdr" mean : reinhard : pfm -o "$work/chain.pfm" "$work/half.exr" "$work/twice.exr"
"$hdr" mean "$work/half.exr" "$work/twice.exr" | "$hdr" reinhard | "$hdr" pfm >"$work/pipe.pfm"
check 'mean through a pipe: the same pixels' cmp -s "$work/chain.pfm" "$work/pipe.pfm"
"$hdr" mean "$work/half.exr" "$work/twice.exr" | head -c 4 >"$work/start"
check 'mean puts pixels on a pipe' is_exr "$work/start"
"$hdr" mean - "$work/twice.exr" <"$work/half.exr" >"$work/stdin.exr"
"$hdr" mean "$work/half.exr" "$work/twice.exr" >"$work/named.exr"
check 'mean of standard input and a file' cmp -s "$work/stdin.exr" "$work/named.exr"
# (1 x 0.5 + 3 x 2) / 4 = 1.625
"$hdr" mean --weights 1,3 -o "$work/weighted.exr" "$work/half.exr" "$work/twice.exr"
"$hdr" expose --ev 0.7004397181410922 -o "$work/wanted.exr" "$room"
"$hdr" error --json --against "$work/wanted.exr" "$work/weighted.exr" >"$work/json"
check 'weights' awk -v e="$(figure smape "$work/json")" 'BEGIN { exit !(e != "" && e < 1e-6) }'
"$hdr" mean --weights 2,2,2 -o "$work/weighted.exr" "$work/half.exr" "$work/twice.exr" "$room"
"$hdr" error --json --against "$work/mean.exr" "$work/weighted.exr" >"$work/json"
check 'equal weights' awk -v e="$(figure smape "$work/json")" 'BEGIN { exit !(e != "" && e < 1e-7) }'
for weights in '' 1 1,2,3 '1,,' 1,0 1,-2 a,b '1,2,' from: From:x; do
    expect_status 64 "--weights '$weights'" "$hdr" mean --weights "$weights" -o "$work/x.exr" "$room" "$room"
done
# weights from the header, as tests/unit/test_exr_attributes.c has them in all types
expect_status 65 'no such attribute' "$hdr" mean --weights from:samplesPerPixel -o "$work/x.exr" "$work/half.exr" "$work/twice.exr"
check 'no such attribute: which file' stderr_has 'half.exr: its header has no attribute'
expect_status 65 'a file without attributes' "$hdr" mean --weights from:samplesPerPixel -o "$work/x.exr" "$work/wide.pfm" "$work/wide.pfm"
check 'no weights: nothing is written' absent "$work/x.exr"
if command -v exrstdattr >/dev/null; then
    exrstdattr -int samplesPerPixel 1 "$work/half.exr" "$work/counted1.exr"
    exrstdattr -string samplesPerPixel 3 "$work/twice.exr" "$work/counted3.exr"
    "$hdr" mean --weights 1,3 : pfm -o "$work/weighted.pfm" "$work/half.exr" "$work/twice.exr"
    "$hdr" mean --weights from:samplesPerPixel -o "$work/counted4.exr" "$work/counted1.exr" "$work/counted3.exr"
    "$hdr" pfm -o "$work/counted.pfm" "$work/counted4.exr"
    check 'weights from the header' cmp -s "$work/weighted.pfm" "$work/counted.pfm"
    "$hdr" info "$work/counted4.exr" >"$work/info"
    check 'the mean has as many samples as all' grep -q 'samplesPerPixel (int) 4$' "$work/info"
    "$hdr" mean --show mean-deviation -o "$work/sigma.exr" "$work/half.exr" "$work/twice.exr"
    "$hdr" mean --weights from:samplesPerPixel : smooth --sigma-picture "$work/sigma.exr" -o "$work/smooth.exr" \
        "$work/counted1.exr" "$work/counted3.exr"
    "$hdr" info "$work/smooth.exr" >"$work/info"
    check 'and so has what is made of it by a second picture' grep -q 'samplesPerPixel (int) 4$' "$work/info"
    "$hdr" mean --weights 4,3 : pfm -o "$work/weighted.pfm" "$work/counted4.exr" "$work/twice.exr"
    "$hdr" mean --weights from:samplesPerPixel : pfm -o "$work/counted.pfm" "$work/counted4.exr" "$work/counted3.exr"
    check 'a mean that is averaged again' cmp -s "$work/weighted.pfm" "$work/counted.pfm"
    "$hdr" mean --weights from:samplesPerPixel "$work/counted1.exr" "$work/counted3.exr" | "$hdr" pfm >"$work/piped.pfm"
    "$hdr" pfm -o "$work/counted.pfm" "$work/counted4.exr"
    check 'weights from the header, through a pipe' cmp -s "$work/piped.pfm" "$work/counted.pfm"
else
    skip 'there is no exrstdattr'
fi
expect_status 64 'weights from the header and a median' "$hdr" mean --weights from:x --robust median-of-means -o "$work/x.exr" "$room" "$room"
expect_status 64 'weights and a variance' "$hdr" mean --weights 1,2 --show variance -o "$work/x.exr" "$room" "$room"
# two numbers a and b: the variance is (a - b)^2 / 2
"$hdr" mean --show variance : stats --json "$work/half.exr" "$work/twice.exr" >"$work/variance"
"$hdr" diff --kind squared --exaggerate 0.5 : stats --json "$work/half.exr" "$work/twice.exr" >"$work/squares"
check 'variance of two' nearly "$(figure max_luminance "$work/variance")" "$(figure max_luminance "$work/squares")"
expect_status 64 'variance of one' "$hdr" mean --show variance -o "$work/x.exr" "$room"
check 'variance of one: nothing is written' absent "$work/x.exr"
expect_status 64 'groups without robust' "$hdr" mean --groups 3 -o "$work/x.exr" "$room"
expect_status 64 'a variance of medians' "$hdr" mean --robust median-of-means --show variance -o "$work/x.exr" "$room" "$room"
expect_status 64 'mean behind a verb' "$hdr" clamp : mean "$room" "$room"
expect_status 64 'mean twice' "$hdr" mean : mean "$room" "$room"
expect_status 64 'info of a mean' "$hdr" mean : info "$room" "$room"
expect_status 64 'bench of a mean' "$hdr" bench mean : durand "$room" "$room"
expect_status 65 'other sizes' "$hdr" mean -o "$work/x.exr" "$room" "$other"
check 'other sizes: one line' one_line_with 'not of one form'
check 'other sizes: nothing is written' absent "$work/x.exr"
expect_status 65 'alpha and none' "$hdr" mean -o "$work/x.exr" testdata/tiny/alpha.exr testdata/tiny/grey.exr
expect_status 66 'a file is missing' "$hdr" mean -o "$work/x.exr" "$room" "$work/missing.exr"
expect_status 0 'NaN in all renders' "$hdr" mean -o "$work/nan.exr" testdata/tiny/specials.exr testdata/tiny/specials.exr
check 'NaN in all renders: told' stderr_has 'NaN'
"$hdr" stats --json "$work/nan.exr" >"$work/json"
check 'NaN in all renders: 0 in the mean' test "$(figure nan "$work/json")" = 0

# ---- diff --------------------------------------------------------------------------------------------------------

expect_status 0 'diff' "$hdr" diff -o "$work/diff.exr" "$work/twice.exr" "$room"
"$hdr" error --json --against "$room" "$work/diff.exr" >"$work/json"
check 'twice a picture less the picture' test "$(figure rmse "$work/json")" = 0
expect_status 64 'diff of one' "$hdr" diff -o "$work/x.exr" "$room"
check 'diff of one: which two' stderr_has 'a test and its reference'
expect_status 64 'diff of three' "$hdr" diff -o "$work/x.exr" "$room" "$room" "$room"
expect_status 64 'epsilon of a signed difference' "$hdr" diff --epsilon 1 -o "$work/x.exr" "$room" "$room"
expect_status 0 'diff of alpha' "$hdr" diff -o "$work/alpha.exr" testdata/object.exr testdata/object.exr
"$hdr" info "$work/alpha.exr" >"$work/info"
check 'diff has no alpha' test "$(grep -c 'channels  *R float, G float, B float$' "$work/info")" -eq 1

# ---- error -------------------------------------------------------------------------------------------------------

expect_status 0 'error' "$hdr" error --against "$room" "$work/twice.exr"
for name in bias mae mse rmse mrse mape smape worst 'left out'; do
    check "error: $name" test "$(grep -c "^  $name " "$work/stdout")" -eq 1
done
check 'error: no PSNR of linear pictures' test "$(grep -c psnr "$work/stdout")" -eq 0
expect_status 0 'error with a peak' "$hdr" error --json --peak 10 --against "$room" "$work/twice.exr"
mse=$(figure mse "$work/stdout")
check 'error: psnr' nearly "$(figure psnr "$work/stdout")" "$(awk -v m="$mse" 'BEGIN { print 10 * log(100 / m) / log(10) }')"
"$hdr" srgb -o "$work/srgb.exr" "$room"
"$hdr" clamp --max 0.5 : srgb -o "$work/dim.exr" "$room"
expect_status 0 'error of encoded pictures' "$hdr" error --json --against "$work/srgb.exr" "$work/dim.exr"
check 'the peak of an encoded picture is 1' test "$(figure peak "$work/stdout")" = 1
expect_status 65 'encoded against linear' "$hdr" error --against "$room" "$work/srgb.exr"
expect_status 0 'a ranking' "$hdr" error --against "$room" "$work/twice.exr" "$room" "$work/half.exr" "$work/half.exr"
check 'a ranking: the picture itself comes first' test "$(sed -n 2p "$work/stdout" | awk '{ print $NF }')" = "$room"
check 'a ranking: the worst comes last' test "$(sed -n 5p "$work/stdout" | awk '{ print $NF }')" = "$work/twice.exr"
check 'a ranking: what is the same cannot be told apart' test "$(sed -n 4p "$work/stdout" | awk '{ print $2 }')" = =
# the sun's square outweighs all others in the room; where all count alike, there is no doubt
"$hdr" clamp --max 0.05 -o "$work/even.exr" testdata/interior.exr
"$hdr" expose --ev 1 -o "$work/even2.exr" "$work/even.exr"
"$hdr" expose --ev -1 -o "$work/even3.exr" "$work/even.exr"
expect_status 0 'a clear ranking' "$hdr" error --against "$work/even.exr" "$work/even2.exr" "$work/even3.exr"
check 'a clear ranking: what differs can be told apart' test "$(sed -n 3p "$work/stdout" | awk '{ print $2 }')" != =
expect_status 0 'csv' "$hdr" error --csv --against "$room" "$work/twice.exr" "$work/half.exr"
check 'csv: a head and two lines' test "$(wc -l <"$work/stdout")" -eq 3
check 'csv: as many fields in all' test "$(awk -F , '{ print NF }' "$work/stdout" | sort -u)" = 9
expect_status 0 'ssim' "$hdr" error --ssim --json --against "$work/srgb.exr" "$work/srgb.exr"
check 'ssim of a picture and itself' nearly "$(figure ssim "$work/stdout")" 1
expect_status 0 'ssim in a table' "$hdr" error --ssim --csv --against "$work/srgb.exr" "$work/dim.exr"
check 'ssim and psnr in a table: two fields more' test "$(awk -F , '{ print NF }' "$work/stdout" | sort -u)" = 11
psnr=$("$hdr" error --json --against "$work/srgb.exr" "$work/dim.exr" | grep -o '"psnr": [^,]*' | sed 's/.*: //')
check 'psnr of encoded pictures in a table, too' nearly "$(sed -n 2p "$work/stdout" | cut -d , -f 11)" "$psnr"
expect_status 65 'a rectangle beside the picture' "$hdr" error --crop 5000,0,2,2 --against "$room" "$room"
check 'nothing to measure: why' stderr_has 'there are no pixels'
expect_status 65 'ssim of few pixels' "$hdr" error --ssim --crop 0,0,11,10 --against "$work/srgb.exr" "$work/dim.exr"
check 'ssim of few pixels: which file' one_line_with 'srgb.exr: structural similarity needs 11 x 11 pixels, and there are 11 x 10'
expect_status 0 'ssim of just enough' "$hdr" error --ssim --crop 0,0,11,11 --against "$work/srgb.exr" "$work/dim.exr"
rmse=$("$hdr" error --json --against "$room" "$work/twice.exr" | grep -o '"rmse": [^,]*' | sed 's/.*: //')
expect_status 0 'threshold: not above' "$hdr" error --threshold "rmse=$rmse" --against "$room" "$work/twice.exr"
below=$(awk -v r="$rmse" 'BEGIN { printf "%.12g", r * 0.999 }')
expect_status 1 'threshold: above' "$hdr" error --threshold "rmse=$below" --against "$room" "$work/twice.exr"
check 'threshold: one line' one_line_with 'above'
for wrong in rmse rmse= rmse=x =1 psnr=3 rmse=-1; do
    expect_status 64 "--threshold $wrong" "$hdr" error --threshold "$wrong" --against "$room" "$room"
done
expect_status 64 'no reference' "$hdr" error "$room"
of_standard_input() { "$hdr" error --against "$room" <"$work/one.exr"; }
expect_status 0 'a test on standard input' of_standard_input
for words in "mean -o $work/x.exr - -" 'noise - -' 'error --against - -' 'error --against -'; do
    # shellcheck disable=SC2086 # words
    expect_status 64 "$words" "$hdr" $words
    check "$words: it is said" one_line_with 'standard input is one picture'
done
# a render that is no picture must not pass: all of it NaN, or a part
make_nan_pictures
expect_status 65 'nothing but NaN' "$hdr" error --threshold rmse=1e9 --against "$work/room.pfm" "$work/nan.pfm"
expect_status 1 'a part of it NaN' "$hdr" error --threshold rmse=1e9 --against "$work/room.pfm" "$work/part.pfm"
check 'a part of it NaN: that is said' one_line_with 'NaN or infinite'
expect_status 65 '--strict error' "$hdr" error --strict --against "$work/room.pfm" "$work/part.pfm"
for words in noise "mean -o $work/x.exr" "diff -o $work/x.exr"; do
    # shellcheck disable=SC2086 # words
    expect_status 65 "--strict $words" "$hdr" $words --strict "$work/part.pfm" "$work/part.pfm"
    check "--strict $words: nothing is written" absent "$work/x.exr"
done
expect_status 65 'nothing in sight' "$hdr" error --crop 9000,0,4,4 --threshold rmse=1e9 --against "$room" "$room"
# what scatters has no alpha; and structure is that of the data window
"$hdr" mean --show deviation -o "$work/deviation.exr" testdata/object.exr testdata/object.exr
"$hdr" info "$work/deviation.exr" >"$work/info"
check 'a deviation has no alpha' test "$(grep -c 'channels  *R float, G float, B float$' "$work/info")" -eq 1
expect_status 64 'csv and json' "$hdr" error --csv --json --against "$room" "$room"
expect_status 64 'a chain in front' "$hdr" clamp : error --against "$room" "$room"
expect_status 66 'no such reference' "$hdr" error --against "$work/missing" "$room"
expect_status 1 'no such test among others' "$hdr" error --against "$room" "$room" "$work/missing"
expect_status 65 'another size' "$hdr" error --against "$room" "$other"

# ---- What the numbers are ----------------------------------------------------------------------------------------

# meaning TEXT WORD...: what the header of the result tells
meaning() {
    wanted=$1
    shift
    "$hdr" "$@" : exr -o "$work/meaning.exr" "$room" "$work/twice.exr"
    "$hdr" info "$work/meaning.exr" | sed -n 's/.* hdrpipeMeaning (string) //p' >"$work/told"
    printf '%s' "$wanted${wanted:+
}" >"$work/wanted"
    check "$*: means $wanted" cmp -s "$work/wanted" "$work/told"
}
meaning 'mean of 2 renders' mean
meaning 'weighted mean of 2 renders' mean --weights 1,2
meaning 'mean of 2 renders: the median of the means of 2 groups, biased' mean --robust median-of-means
meaning 'variance of one of 2 renders' mean --show variance
meaning 'standard deviation of the mean of 2 renders' mean --show mean-deviation
meaning 'x - r' diff
meaning '|x - r|, times 3' diff --kind absolute --exaggerate 3
meaning '|x - r| / (|r| + E), E = 0.01' diff --kind relative
meaning '|x - r| / (|x| + |r| + E), E = 0.5' diff --kind smape --epsilon 0.5
meaning '(x - r)^2' diff --kind squared
meaning '' mean : clamp
"$hdr" mean --show mean-deviation -o "$work/sigma.exr" "$room" "$work/twice.exr"
meaning 'mean of 2 renders, smoothed: non-local means, k 0.45, window 3 x 3, patches 1 x 1; biased' \
    mean : smooth --radius 1 --patch 0 --sigma-picture "$work/sigma.exr"
"$hdr" exr --type half -o "$work/half_sigma.exr" "$work/sigma.exr"
"$hdr" info "$work/half_sigma.exr" >"$work/stdout"
check 'it goes along into a copy' grep -q 'hdrpipeMeaning (string) standard deviation of the mean of 2 renders' "$work/stdout"
"$hdr" expose --ev 1 -o "$work/altered.exr" "$work/sigma.exr"
"$hdr" info "$work/altered.exr" >"$work/stdout"
check 'and not into what is another picture' test "$(grep -c hdrpipeMeaning "$work/stdout")" -eq 0
"$hdr" mean -o "$work/again.exr" "$work/sigma.exr" "$work/sigma.exr"
"$hdr" info "$work/again.exr" >"$work/stdout"
check 'a mean of such has its own' test "$(grep -c hdrpipeMeaning "$work/stdout")" -eq 1
expect_status 65 'weights from nothing' "$hdr" mean --weights from:nothing : smooth --sigma-picture "$work/sigma.exr" -o "$work/x.exr" "$room" "$work/twice.exr"
check 'a file of several is named once' grep -qx "hdr: $room: its header has no attribute 'nothing'" "$work/stderr"

finish test_measure

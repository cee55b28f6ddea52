#!/bin/sh
# FLIP on the command line. What it computes is compared with its definition in tests/oracle/test_flip.c.
. tests/cli/lib.sh

room=testdata/interior_float.exr
"$hdr" expose --ev 0.5 -o "$work/bright.exr" "$room"
"$hdr" clamp --max 0.2 -o "$work/dull.exr" "$room"
"$hdr" srgb -o "$work/codes.exr" "$room"
"$hdr" clamp --max 0.5 : srgb -o "$work/dim.exr" "$room"

# figure NAME FILE: a number or text of the JSON there
figure() {
    grep -o "\"$1\": [^,}]*" "$2" | head -n 1 | sed 's/.*: //'
}

# within A B PART: A is B to that part of it
within() {
    awk -v a="$1" -v b="$2" -v part="$3" 'BEGIN { exit !(a != "" && b != "" && (a - b) ^ 2 <= (part * b) ^ 2) }'
}

# ---- Which it is -------------------------------------------------------------------------------------------------

expect_status 0 'light' "$hdr" error --flip auto --json --against "$room" "$work/bright.exr"
cp "$work/stdout" "$work/light"
check 'light: HDR-FLIP' test "$(figure kind "$work/light")" = '"hdr"'
check 'light: of how many exposures' test "$(figure exposures "$work/light")" -ge 2
check 'light: by which tone mapper' test "$(figure tone_mapper "$work/light")" = '"aces"'
expect_status 0 'codes' "$hdr" error --flip auto --json --against "$work/codes.exr" "$work/dim.exr"
check 'codes: LDR-FLIP' test "$(figure kind "$work/stdout")" = '"ldr"'
check 'codes: no exposures' test "$(grep -c exposures "$work/stdout")" -eq 0
codes=$(figure mean "$work/stdout")
expect_status 0 'light on a display' "$hdr" error --flip ldr --json --against "$room" "$work/dull.exr"
check 'light on a display: LDR-FLIP' test "$(figure kind "$work/stdout")" = '"ldr"'
"$hdr" clamp --max 0.5 -o "$work/half.exr" "$room"
"$hdr" error --flip ldr --json --against "$room" "$work/half.exr" >"$work/json"
check 'LDR-FLIP of light is that of its codes' within "$(figure mean "$work/json")" "$codes" 1e-4
expect_status 65 'HDR-FLIP of codes' "$hdr" error --flip hdr --against "$work/codes.exr" "$work/dim.exr"
check 'HDR-FLIP of codes: it is said' one_line_with 'encoded (srgb)'
"$hdr" error --flip auto --json --against "$room" "$room" >"$work/json"
check 'a picture and itself' test "$(figure mean "$work/json") $(figure max "$work/json")" = '0 0'

# ---- The same whatever computes it -------------------------------------------------------------------------------

for words in -j1 -j3 --memory=1M --no-skip --reference; do
    "$hdr" error --flip auto --json "$words" --against "$room" "$work/bright.exr" >"$work/json"
    check "$words: the same to the last digit" cmp -s "$work/light" "$work/json"
done
for cpu in c sse2 avx2 avx512; do
    HDR_CPU=$cpu "$hdr" error --flip auto --json --against "$room" "$work/bright.exr" >"$work/json"
    check "HDR_CPU=$cpu: the same to the last digit" cmp -s "$work/light" "$work/json"
done
# a second test finds what was kept of the reference, or finds it anew
mean=$(figure mean "$work/light")
for words in -j2 --memory=1M; do
    "$hdr" error --flip auto --json "$words" --against "$room" "$work/dull.exr" "$work/bright.exr" "$work/bright.exr" >"$work/json"
    check "several tests, $words" test "$(grep -c "\"mean\": $mean," "$work/json")" -eq 2
done
"$hdr" error --flip auto --json --pixels-per-degree 20 --against "$room" "$work/bright.exr" >"$work/json"
check 'another distance: another figure' test "$(figure mean "$work/json")" != "$mean"
check 'another distance: it is told' test "$(figure pixels_per_degree "$work/json")" = 20

# ---- Printing ----------------------------------------------------------------------------------------------------

expect_status 0 'words' "$hdr" error --flip auto --against "$room" "$work/bright.exr"
check 'words: which it is' test "$(grep -c '^  flip  *0\.[0-9]* *mean of HDR-FLIP, 67.0206 pixels per degree, [0-9]* exposures from -[0-9.]* to -*[0-9.]*, ACES$' "$work/stdout")" -eq 1
check 'words: how it is spread' test "$(grep -c '^  *min .*, max .* at [0-9]*,[0-9]*, weighted median .*, quartiles .* and ' "$work/stdout")" -eq 1
expect_status 0 'csv' "$hdr" error --flip auto --csv --ssim --peak 1 --against "$room" "$work/bright.exr" "$work/dull.exr"
check 'csv: as many fields in all' test "$(awk -F , '{ print NF }' "$work/stdout" | sort -u)" = 18
check 'csv: the same mean' within "$(awk -F , -v name="$work/bright.exr" '$1 == name { print $11 }' "$work/stdout")" "$mean" 1e-15
"$hdr" error --flip auto --csv --against "$work/codes.exr" "$work/dim.exr" >"$work/csv"
check 'csv: as many fields without exposures, and psnr' test "$(awk -F , '{ print NF }' "$work/csv" | sort -u)" = 17
expect_status 0 'a ranking' "$hdr" error --rank flip --against "$room" "$work/dull.exr" "$room" "$work/bright.exr"
check 'a ranking: by flip' test "$(awk 'NR == 1 { print $2 }' "$work/stdout")" = flip
check 'a ranking: the picture itself comes first' test "$(sed -n 2p "$work/stdout" | awk '{ print $NF }')" = "$room"
check 'a ranking: in order' test "$(sed -n 3,4p "$work/stdout" | awk '{ print $2 }' | sort -g -c 2>&1)" = ''
check 'a ranking: which it is' test "$(grep -c '^flip is the mean of HDR-FLIP, ' "$work/stdout")" -eq 1
expect_status 0 'threshold: not above' "$hdr" error --threshold "flip=$mean" --against "$room" "$work/bright.exr"
expect_status 1 'threshold: above' "$hdr" error --threshold flip=0.001 --against "$room" "$work/bright.exr"
check 'threshold: it is said' one_line_with 'flip is 0.'

# ---- The map -----------------------------------------------------------------------------------------------------

expect_status 0 'a map' "$hdr" error --flip-map "$work/map.exr" --json --against "$room" "$work/bright.exr"
"$hdr" stats --json "$work/map.exr" >"$work/json"
check 'a map: its largest is the figure' within "$(figure max_luminance "$work/json")" "$(figure max "$work/stdout")" 1e-6
check 'a map: of all pixels' test "$(figure pixels "$work/json")" = "$("$hdr" stats --json "$room" | grep -o '"pixels": [0-9]*' | sed 's/.*: //')"
x=$(figure x "$work/stdout" | head -n 1) y=$(figure y "$work/stdout" | head -n 1)
"$hdr" stats --json --crop "$x,$y,1,1" "$work/map.exr" >"$work/json"
check 'a map: the largest is where it is told to be' within "$(figure max_luminance "$work/json")" "$(figure max "$work/stdout")" 1e-6
expect_status 64 'a map of two tests' "$hdr" error --flip-map "$work/x.exr" --against "$room" "$room" "$room"
check 'a map of two tests: nothing is written' absent "$work/x.exr"
expect_status 66 'a map of nothing' "$hdr" error --flip-map "$work/x.exr" --against "$room" "$work/missing.exr"
check 'a map of nothing: nothing is written' absent "$work/x.exr"
expect_status 73 'a map nowhere' "$hdr" error --flip-map "$work/none/x.exr" --against "$room" "$room"
expect_status 0 'a part of a picture' "$hdr" error --flip auto --json --crop 40,50,30,20 --against "$room" "$work/bright.exr"
x=$(figure x "$work/stdout" | head -n 1) y=$(figure y "$work/stdout" | head -n 1)
check 'a part of a picture: in the coordinates of the whole' test "$x" -ge 40 -a "$x" -lt 70 -a "$y" -ge 50 -a "$y" -lt 70

# ---- What is refused, or no picture ------------------------------------------------------------------------------

for words in '--flip hd' '--flip' '--pixels-per-degree 60' '--flip auto --pixels-per-degree 0' \
    '--flip auto --pixels-per-degree 1001' '--flip-map -' '--threshold flip=' '--threshold flip=x' '--rank flap'; do
    # shellcheck disable=SC2086 # words
    expect_status 64 "$words" "$hdr" error $words --against "$room" "$room"
done
expect_status 65 'another size' "$hdr" error --flip auto --against "$room" testdata/glossy.exr
make_nan_pictures
expect_status 65 'nothing but NaN' "$hdr" error --threshold flip=1 --against "$work/room.pfm" "$work/nan.pfm"
expect_status 1 'a part of it NaN' "$hdr" error --threshold flip=1 --against "$work/room.pfm" "$work/part.pfm"
check 'a part of it NaN: that is said' one_line_with 'NaN or infinite'
expect_status 0 'alpha' "$hdr" error --flip auto --against testdata/object.exr testdata/object.exr

# ---- Published figures -------------------------------------------------------------------------------------------

# OpenImageIO's testsuite/flip/ref/out.txt, of these pictures: a part of those of FLIP's authors
crops=${HDRPIPE_CORPUS:-../shared/corpus}/render
if [ -f "$crops/crop_reference.exr" ]; then
    "$hdr" error --flip hdr --json --against "$crops/crop_reference.exr" "$crops/crop_test.exr" >"$work/json"
    check 'published: HDR-FLIP, mean' within "$(figure mean "$work/json")" 0.2789 2e-4
    check 'published: HDR-FLIP, max' within "$(figure max "$work/json")" 0.8402 6e-5
    check 'published: HDR-FLIP, where' test "$(figure x "$work/json"),$(figure y "$work/json")" = 110,137
    check 'published: HDR-FLIP, start' within "$(figure start "$work/json")" -12.5 4e-3
    check 'published: HDR-FLIP, stop' within "$(figure stop "$work/json")" 1.11 5e-3
    check 'published: HDR-FLIP, exposures' test "$(figure exposures "$work/json")" = 14
    "$hdr" error --flip ldr --json --against "$crops/crop_reference.exr" "$crops/crop_test.exr" >"$work/json"
    check 'published: LDR-FLIP, mean' within "$(figure mean "$work/json")" 0.309864 1e-5
    check 'published: LDR-FLIP, max' within "$(figure max "$work/json")" 0.775379 1e-5
    check 'published: LDR-FLIP, where' test "$(figure x "$work/json"),$(figure y "$work/json")" = 21,146
else
    skip "there is no $crops/crop_reference.exr"
fi

finish test_flip

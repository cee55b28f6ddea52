#!/bin/sh
# --alpha: kept, dropped, or laid over a colour; and colour that a PNG cannot show.
. tests/cli/lib.sh

tiny=testdata/tiny
alpha=$tiny/alpha.exr

# pixel FILE WIDTH HEIGHT X Y: a pixel of a colour PFM, y downwards, as "R G B".
pixel() {
    tail -c $((12 * $2 * $3)) "$1" | tail -c +$((12 * ($2 * ($3 - 1 - $5) + $4) + 1)) | head -c 12 |
        od -An -tf4 | awk '{ print $1, $2, $3 }'
}

# alpha_pixel X Y WANTED: of what was written last to a.pfm from alpha.exr or a picture of its size
alpha_pixel() {
    check "$option: pixel $1,$2 is $3 and not $(pixel "$work/a.pfm" 8 4 "$1" "$2")" \
        test "$(pixel "$work/a.pfm" 8 4 "$1" "$2")" = "$3"
}

# written OPTIONS FILE: to a.pfm, without a word but that of PFM's missing alpha
written() {
    option=$1
    # shellcheck disable=SC2086 # options and their values
    expect_status 0 "$option" "$hdr" pfm $option -q -o "$work/a.pfm" "$2"
}

# ---- What they do ------------------------------------------------------------------------------------------------

# alpha.exr: alpha is 0, 0.25, 0.5 and 1 in its four rows; straight colour (x/8, 0.5, 1 - x/8); in row 0 emission
# (x/4, 0.5, 0.25) from x = 4 on
written '--alpha drop' "$alpha"
alpha_pixel 3 0 '0 0 0'
alpha_pixel 4 0 '1 0.5 0.25'
alpha_pixel 4 1 '0.125 0.125 0.125'
alpha_pixel 2 2 '0.125 0.25 0.375'
alpha_pixel 6 3 '0.75 0.5 0.25'
written '--alpha over:1,0.5,-.25' "$alpha"
alpha_pixel 3 0 '1 0.5 -0.25'
alpha_pixel 4 0 '2 1 0'
alpha_pixel 4 1 '0.875 0.5 -0.0625'
alpha_pixel 2 2 '0.625 0.5 0.25'
alpha_pixel 6 3 '0.75 0.5 0.25'
written '--alpha over:0,0,0' "$alpha"
cp "$work/a.pfm" "$work/black.pfm"
written '--alpha drop' "$alpha"
check 'over black is the colour as stored' cmp -s "$work/a.pfm" "$work/black.pfm"
expect_status 0 'keep to EXR' "$hdr" exr --type half --alpha keep -o "$work/keep.exr" "$alpha"
expect_status 0 'the default to EXR' "$hdr" exr --type half -o "$work/default.exr" "$alpha"
check 'keep is the default' cmp -s "$work/keep.exr" "$work/default.exr"

# the result has no alpha
for how in drop over:1,1,1; do
    expect_status 0 "$how to EXR" "$hdr" exr --alpha "$how" -o "$work/a.exr" "$alpha"
    "$hdr" info "$work/a.exr" >"$work/stdout"
    check "$how: no alpha is written" grep -q 'R float, G float, B float$' "$work/stdout"
    "$hdr" stats --alpha "$how" --json "$alpha" >"$work/one"
    "$hdr" stats --json "$work/a.exr" >"$work/two"
    for fact in log_average max_luminance lit; do
        check "$how: $fact is that of what is written" test \
            "$(grep -o "\"$fact\": [^,]*" "$work/one")" = "$(grep -o "\"$fact\": [^,]*" "$work/two")"
    done
done

# outside the data window (11 x 9 at -2,1 in 12 x 8 at 0,0) the colour stands alone
for how in keep drop over:1,0.5,0.25; do
    expect_status 0 "window, $how" "$hdr" expose --ev 1 : pfm --alpha "$how" -o "$work/w.pfm" "$tiny/window.exr"
    wanted='0 0 0'
    if [ "$how" = over:1,0.5,0.25 ]; then wanted='2 1 0.5'; fi
    for place in '0 0' '11 0' '11 5' '9 3'; do
        # shellcheck disable=SC2086 # two numbers
        found=$(pixel "$work/w.pfm" 12 8 $place)
        check "window, $how, $place: $found" test "$found" = "$wanted"
    done
    check "window, $how: inside" test "$(pixel "$work/w.pfm" 12 8 0 1)" = '0.375 0.125 0.5'
done

# nothing is there to be laid over anything
for file in grey constant ramp primaries; do
    "$hdr" png -o "$work/a.png" "$tiny/$file.exr"
    for how in drop over:1,0,0; do
        expect_status 0 "$how of $file" "$hdr" png --alpha "$how" -o "$work/b.png" "$tiny/$file.exr"
        check "$file has no alpha: $how changes nothing" cmp -s "$work/a.png" "$work/b.png"
    done
done

# ---- The same however it is run ----------------------------------------------------------------------------------

for file in "$alpha" "$tiny/window.exr" "$tiny/opaque.exr" testdata/object.exr; do
    for how in keep drop over:0.5,0.5,0.5 over:0.1,0.2,3; do
        for format in png exr; do
            name="${file##*/} $how to $format"
            "$hdr" exp --alpha "$how" : "$format" -q -j 1 -o "$work/a.$format" "$file"
            for option in '-j 3' --reference --no-skip '--memory 1M'; do
                # shellcheck disable=SC2086 # an option and its value
                expect_status 0 "$name $option" "$hdr" exp --alpha "$how" : "$format" -q $option -o "$work/b.$format" "$file"
                check "$name $option: the same bytes" cmp -s "$work/a.$format" "$work/b.$format"
            done
            "$hdr" exp --alpha "$how" <"$file" | "$hdr" "$format" -q >"$work/b.$format"
            check "$name: a pipe gives the same bytes" cmp -s "$work/a.$format" "$work/b.$format"
            "$hdr" exp <"$file" | "$hdr" "$format" -q --alpha="$how" >"$work/b.$format"
            check "$name: given to the last program of a pipe" cmp -s "$work/a.$format" "$work/b.$format"
        done
    done
done

# outside the data window a pixel has nothing around it but its like: the base is its own, the detail none, and 0.18
for option in -q --reference --no-skip -j1; do
    "$hdr" durand --show detail --alpha over:0.5,0.5,0.5 : pfm "$option" -o "$work/border.pfm" testdata/tiny/window.exr
    border=$(tail -n +4 "$work/border.pfm" | od -An -tf4 -j 120 -N4 | tr -d ' ')
    check "durand of a border, $option: detail is $border" test "$border" = 0.18
done

# ---- Colour that does not show -----------------------------------------------------------------------------------

expect_status 0 'emission to PNG' "$hdr" clamp : png -j 2 -o "$work/a.png" "$alpha"
check 'emission to PNG: one line' one_line_with alpha.exr
check 'emission to PNG: counted' stderr_has ' 4 pixels have a colour but an alpha of 0'
expect_status 0 'emission to PNG, twice over' "$hdr" log : png -o "$work/a.png" "$alpha"
check 'emission to PNG: one line though the facts need a sweep' stderr_lines 1
expect_status 0 'emission to EXR' "$hdr" exr -o "$work/a.exr" "$alpha"
check 'emission to EXR: nothing to say' stderr_lines 0
expect_status 0 'emission to PNG, quiet' "$hdr" png -q -o "$work/a.png" "$alpha"
check 'emission to PNG, quiet' stderr_lines 0
for how in drop over:0,0,0; do
    expect_status 0 "emission, $how" "$hdr" clamp : png --alpha "$how" -o "$work/a.png" "$alpha"
    check "emission, $how: nothing to say" stderr_lines 0
done
expect_status 0 'cover without colour' "$hdr" png -o "$work/a.png" "$tiny/opaque.exr"
check 'cover without colour: nothing to say' stderr_lines 0
corpus=${HDRPIPE_CORPUS:-../shared/corpus}
if [ -f "$corpus/photo/Carrots.exr" ]; then
    expect_status 0 'a photograph whose alpha is 0' "$hdr" png -o "$work/a.png" "$corpus/photo/Carrots.exr"
    check 'a photograph whose alpha is 0' stderr_has ' 240000 pixels have'
else
    skip "there is no $corpus"
fi

# ---- What is refused ---------------------------------------------------------------------------------------------

for how in '' Keep none over over: over:1 over:1,2 over:1,2,3,4 'over:1,2,3,' over:,1,2 over:1,2,x over:nan,0,0 \
    over:inf,0,0 over:1e39,0,0 'over:1, 2,3' over:0x1,1,1; do
    expect_status 64 "--alpha '$how'" "$hdr" png --alpha "$how" -o "$work/no.png" "$alpha"
    check "--alpha '$how': says what may stand there" stderr_has 'keep, drop or over:R,G,B'
    check "--alpha '$how': nothing is written" absent "$work/no.png"
done
expect_status 64 'twice' "$hdr" log --alpha drop : png --alpha drop -o "$work/no.png" "$alpha"
"$hdr" log --alpha drop <"$alpha" | cat >"$work/head"
expect_status 64 'two programs of a pipe differ' "$hdr" png --alpha keep -o "$work/no.png" "$work/head"
printf 'hdrpipe 1\nread --alpha over:1,2\nthen log\n\n' >"$work/bad"
expect_status 65 'a head with half a colour' "$hdr" png -o "$work/no.png" "$work/bad"

finish test_alpha

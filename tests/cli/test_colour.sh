#!/bin/sh
# What a PNG says of its values: the curve, the primaries, the bits that count; and what is said where a picture is not in the state that it ought to be in.
. tests/cli/lib.sh
picture=testdata/tiny/ramp.exr
foreign=testdata/tiny/foreign.exr
bright=testdata/interior.exr

# chunk TYPE FILE: its bytes, in hexadecimal; nothing where there is none
chunk() {
    at=$(LC_ALL=C grep -abo "$1" "$2" | head -n 1 | cut -d: -f1)
    if [ -z "$at" ]; then return; fi
    length=$(od -An -tu1 -j$((at - 1)) -N1 "$2") # none of these is longer than 255
    od -An -v -tx1 -j$((at + 4)) -N"$((length))" "$2" | tr -d ' \n'
}

# says NAME FILE sRGB gAMA cHRM cICP sBIT: each chunk's bytes, '-' where there is to be none
says() {
    says_name=$1 file=$2
    shift 2
    for type in sRGB gAMA cHRM cICP sBIT; do
        expected=$1
        shift
        if [ "$expected" = - ]; then expected=; fi
        found=$(chunk $type "$file")
        check "$says_name: $type is '$found', not '$expected'" test "$found" = "$expected"
    done
}

# made CHAIN FILE: a PNG that pngcheck finds nothing wrong with. It is older than cICP, a chunk of 16 bytes, which is taken out before.
made() {
    # shellcheck disable=SC2086 # they are several words
    expect_status 0 "$1" "$hdr" $1 -q -o "$work/a.png" "$2"
    if [ -z "$pngcheck" ]; then return; fi
    at=$(LC_ALL=C grep -abo cICP "$work/a.png" | head -n 1 | cut -d: -f1)
    if [ -n "$at" ]; then
        { head -c $((at - 4)) "$work/a.png" && tail -c +$((at + 13)) "$work/a.png"; } >"$work/known.png"
    else
        cp "$work/a.png" "$work/known.png"
    fi
    check "$1: pngcheck" pngcheck -q "$work/known.png"
}

pngcheck=$(command -v pngcheck)
if [ -z "$pngcheck" ]; then skip 'there is no pngcheck'; fi

# ---- Curves --------------------------------------------------------------------------------------------------------

# 1/2.2 and 1/1.8 and 1/2.4 of 100000, and 100000
gamma22=0000b18f gamma18=0000d904 gamma24=0000a2c3 linear=000186a0
# 0.3127 0.329, 0.64 0.33, 0.3 0.6, 0.15 0.06
rec709=00007a26000080840000fa00000080e8000075300000ea6000003a9800001770
bt2020=00007a2600008084000114900000721000004268000137540000332c000011f8
for bits in 8 16; do
    made "png --bits $bits" $picture
    says "png --bits $bits" "$work/a.png" 00 $gamma22 $rec709 - -
    made "srgb : png --bits $bits" $picture
    says "srgb, $bits bits" "$work/a.png" 00 $gamma22 $rec709 - -
    made "gamma -g 1.8 : png --bits $bits" $picture
    says "gamma 1.8, $bits bits" "$work/a.png" - $gamma18 - - -
    made "gamma -g 2.4 : png --bits $bits" $picture
    says "gamma 2.4, $bits bits" "$work/a.png" - $gamma24 - - -
    made "rec709 : png --bits $bits" $picture
    says "rec709, $bits bits" "$work/a.png" - - - 01010001 -
    made "pq : png --bits $bits" $picture
    says "pq, $bits bits" "$work/a.png" - - - 01100001 -
    made "hlg : png --bits $bits" $picture
    says "hlg, $bits bits" "$work/a.png" - - - 01120001 -
    made "quantise --bits $bits : png" $picture
    says "linear, $bits bits" "$work/a.png" - $linear - - -
    made "srgb : srgb --decode : quantise --bits $bits : png" $picture
    says "linear again, $bits bits" "$work/a.png" - $linear - - -
done
made 'png --dither blue' $picture
says 'dithered' "$work/a.png" 00 $gamma22 $rec709 - -

# ---- Primaries -----------------------------------------------------------------------------------------------------

made 'png --primaries keep' $foreign
says 'srgb in BT.2020' "$work/a.png" - $gamma22 $bt2020 - -
made 'gamma -g 1.8 : png --primaries keep' $foreign
says 'gamma in BT.2020' "$work/a.png" - $gamma18 $bt2020 - -
made 'quantise : png --primaries keep' $foreign
says 'linear in BT.2020' "$work/a.png" - $linear $bt2020 - -
made 'pq : png --primaries keep --bits 16' $foreign
says 'pq in BT.2020' "$work/a.png" - - $bt2020 09100001 -
made 'hlg : png --primaries keep --bits 16' $foreign
says 'hlg in BT.2020' "$work/a.png" - - $bt2020 09120001 -
made 'rec709 : png --primaries keep' $foreign
says 'rec709 in BT.2020' "$work/a.png" - - $bt2020 09010001 -
for chain in png 'pq : png' 'hlg : png' 'rec709 : png'; do
    made "$chain" $foreign
    check "$chain of BT.2020, converted: not its cHRM" test "$(chunk cHRM "$work/a.png")" != $bt2020
    check "$chain of BT.2020, converted: Rec.709's cICP, if any" test "$(chunk cICP "$work/a.png" | cut -c 1-2)" != 09
done
# primaries that have no code: neither cICP nor a wrong word
printf 'PFS1\n2 1\n3\n0\nX\n0\nY\n0\nZ\n0\nENDH\0\0\0\077\0\0\0\076\0\0\0\077\0\0\0\076\0\0\0\077\0\0\0\076' >"$work/xyz.pfs"
expect_status 0 'pq of X, Y and Z' "$hdr" pq : png --primaries keep -q -o "$work/a.png" "$work/xyz.pfs"
check 'pq of X, Y and Z: no cICP' test -z "$(chunk cICP "$work/a.png")"
check 'pq of X, Y and Z: no gAMA' test -z "$(chunk gAMA "$work/a.png")"

# ---- Bits that count ------------------------------------------------------------------------------------------------

# depth FILE: of a sample
depth() {
    od -An -tu1 -j24 -N1 "$1" | tr -d ' '
}
for dither in none ordered blue; do
    for bits in 5 8 10 12 16; do
        made "srgb : quantise --bits $bits --dither $dither : png" testdata/tiny/primaries.exr
        wide=$(if [ $bits -le 8 ]; then echo 8; else echo 16; fi)
        check "$bits bits: samples of $wide" test "$(depth "$work/a.png")" = "$wide"
        significant=$(if [ $bits = "$wide" ]; then echo -; else printf '%02x%02x%02x' $bits $bits $bits; fi)
        says "$bits bits, dither $dither" "$work/a.png" 00 $gamma22 $rec709 - "$significant"
        made "pq : quantise --bits $bits --dither $dither : png" $picture
        significant=$(if [ $bits = "$wide" ]; then echo -; else printf '%02x' $bits; fi)
        says "pq of $bits bits, dither $dither" "$work/a.png" - - - 01100001 "$significant"
    done
done
made 'srgb : quantise --bits 10 : png' testdata/tiny/alpha.exr
check 'sBIT of alpha' test "$(chunk sBIT "$work/a.png")" = 0a0a0a10

# ---- The state goes along through EXR --------------------------------------------------------------------------------

for encoding in srgb 'gamma -g 1.8' rec709 'pq --nits 203' hlg; do
    # shellcheck disable=SC2086 # they are several words
    {
        "$hdr" $encoding -o "$work/encoded.exr" $picture
        expect_status 0 "$encoding, read again" "$hdr" png --bits 16 -o "$work/by_file.png" "$work/encoded.exr"
        check "$encoding, read again: nothing to say" stderr_lines 0
        "$hdr" $encoding : png --bits 16 -o "$work/direct.png" $picture
        for type in sRGB gAMA cICP; do
            check "$encoding, read again: $type" test "$(chunk $type "$work/by_file.png")" = "$(chunk $type "$work/direct.png")"
        done
        expect_status 65 "$encoding, encoded again" "$hdr" rec709 : png -o "$work/a.png" "$work/encoded.exr"
        check "$encoding, encoded again: it is said" one_line_with "encoded already (${encoding%% *}"
        expect_status 0 "$encoding, decoded" "$hdr" $encoding --decode : srgb : png -o "$work/a.png" "$work/encoded.exr"
        "$hdr" png -o "$work/b.png" $picture
        check "$encoding, decoded: the codes of the original" cmp -s "$work/a.png" "$work/b.png"
    }
done

# ---- Light and what is encoded -----------------------------------------------------------------------------------------

# said WORDS CHAIN: one line with the words
said() {
    # shellcheck disable=SC2086 # they are several words
    expect_status 0 "$2" "$hdr" $2 -o "$work/said.${3:-png}" "${4:-$bright}"
    check "$2: one line with '$1', not $(cat "$work/stderr")" one_line_with "$1"
}
unsaid() {
    # shellcheck disable=SC2086 # they are several words
    expect_status 0 "$1" "$hdr" $1 -o "$work/said.${2:-png}" "${3:-$bright}"
    check "$1: nothing to say, but $(cat "$work/stderr")" stderr_lines 0
}
for verb in divmax log exp reinhard 'reinhard --local' durand 'expose --auto' 'log --mode range' 'log --mode literal'; do
    said "clause 2 (${verb%% *}): " "srgb : $verb" exr
    check "srgb : $verb: the way out" stderr_has "(srgb --decode then ${verb%% *})"
    unsaid "srgb : srgb --decode : $verb" exr
    unsaid "$verb : srgb" exr
done
for verb in clamp 'expose --ev 1' 'srgb --decode' quantise 'gamma --force'; do
    unsaid "srgb : $verb" exr
done
"$hdr" exp : gamma -g 1.8 -o "$work/encoded.exr" "$bright"
said '(gamma 1.8)' log exr "$work/encoded.exr"
check 'an encoded file: the way out' stderr_has '(gamma --exponent 1.8 --decode then log)'

# ---- Light that codes cannot hold --------------------------------------------------------------------------------------

# the largest component of interior.exr, as the note has it
largest=$("$hdr" stats --json "$bright" | sed 's/.*"max": {\([^}]*\)}.*/\1/' | tr ',' '\n' | sed 's/.*: //' | sort -g | tail -n 1)
for chain in png 'png --bits 16' 'png --no-skip' 'png --reference' 'png -j 1' 'png --dither blue' srgb 'gamma -g 1.8' rec709 hlg 'srgb : png --bits 16' \
    'clamp --max 1000000 : png' 'srgb : expose --ev 0.5'; do
    said "its light reaches $largest, " "$chain"
done
said "its light reaches $((4 * largest)), " 'expose --ev 2 : srgb'
for chain in 'clamp : png' 'divmax : png' 'divmax --percentile 50 : png' 'log : png' 'log --mode range : png' 'exp : png' \
    'reinhard --white inf : png' 'durand : png' 'clamp : expose --ev 3 : png' 'log : srgb : png --dither blue' 'srgb : quantise --bits 5 : png' 'pq --nits 1' 'pq --nits 1 : png --bits 16'; do
    unsaid "$chain"
done
said 'its light reaches ' 'pq --nits 1000 : png'
unsaid srgb exr
unsaid png png $picture
unsaid png png testdata/tiny/black.exr
"$hdr" srgb -o "$work/encoded.exr" "$bright"
unsaid png png "$work/encoded.exr"
# what no code shows is no loss: 1.001 rounds to 255 of 255, and not to 65535 of 65535
printf 'Pf\n1 1\n-1.0\n\305\040\200\077' >"$work/hardly.pfm" # 1.001
unsaid png png "$work/hardly.pfm"
said 'its light reaches 1.001, ' 'png --bits 16' png "$work/hardly.pfm"
"$hdr" srgb "$bright" | "$hdr" quantise --bits 4 --dither blue --seed 7 | "$hdr" png -q >"$work/piped.png"
"$hdr" srgb : quantise --bits 4 --dither blue --seed 7 : png -q -o "$work/a.png" "$bright"
check 'dither through pipes' cmp -s "$work/a.png" "$work/piped.png"
"$hdr" log "$bright" | "$hdr" png --dither ordered -j 2 >"$work/piped.png"
"$hdr" log : png --dither ordered -j 1 -o "$work/a.png" "$bright"
check 'dither at the end of a pipe' cmp -s "$work/a.png" "$work/piped.png"
expect_status 0 'through a pipe' sh -c "'$hdr' srgb '$bright' | '$hdr' png >'$work/piped.png'"
check 'through a pipe: once' one_line_with 'its light reaches'
expect_status 0 'quiet' "$hdr" png -q -o "$work/a.png" "$bright"
check 'quiet: nothing' stderr_lines 0

# light that was encoded by other nits is decoded by those, and by another curve not without a word
"$hdr" clamp : pq --nits 203 -o "$work/pq203.exr" testdata/interior.exr
"$hdr" info "$work/pq203.exr" >"$work/stdout"
check 'nits are part of the state' grep -q 'pq 203' "$work/stdout"
expect_status 0 'pq 203 is told on' "$hdr" exp -o "$work/x.exr" "$work/pq203.exr"
check 'pq 203: the way out' stderr_has 'pq --nits 203 --decode'
expect_status 0 'pq 203 decoded' "$hdr" pq --nits 203 --decode -o "$work/x.exr" "$work/pq203.exr"
check 'pq 203 decoded: nothing to say' stderr_lines 0
"$hdr" png --bits 16 -o "$work/pq203.png" "$work/pq203.exr"
check 'a PNG of it names the curve' grep -aq cICP "$work/pq203.png"
for words in 'pq --decode' 'srgb --decode' 'hlg --decode' 'gamma --decode'; do
    # shellcheck disable=SC2086 # words
    expect_status 0 "$words of pq 203" "$hdr" $words -o "$work/x.exr" "$work/pq203.exr"
    check "$words of pq 203: it is said" one_line_with 'and the picture is encoded by another curve (pq 203)'
done
expect_status 65 'pq 203 encoded again' "$hdr" srgb -o "$work/x.exr" "$work/pq203.exr"
check 'pq 203 encoded again: the way out' stderr_has 'pq --nits 203 --decode'

finish test_colour

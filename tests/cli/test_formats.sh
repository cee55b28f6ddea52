#!/bin/sh
# Radiance HDR, PFM and PFS on both sides: against other programs' reading, behind a head in a pipe, by name.
. tests/cli/lib.sh

picture=$PWD/testdata/interior.exr
grey=$PWD/testdata/tiny/grey.exr
translucent=$PWD/testdata/tiny/alpha.exr

# ---- The format follows the name ---------------------------------------------------------------------------------

# begins FILE TEXT
begins() {
    [ "$(head -c ${#2} "$1")" = "$2" ]
}
for pair in 'hdr #?RADIANCE' 'pfs PFS1' 'pfm PF'; do
    ending=${pair%% *} start=${pair#* }
    expect_status 0 "-o a.$ending" "$hdr" expose -q --ev 1 -o "$work/a.$ending" "$picture"
    check "-o a.$ending: its first bytes" begins "$work/a.$ending" "$start"
    "$hdr" expose --ev 1 "$picture" >"$work/b.$ending"
    check "> b.$ending: the same" cmp -s "$work/a.$ending" "$work/b.$ending"
done
expect_status 64 'an ending of no format' "$hdr" expose -o "$work/a.jpg" "$picture"
for ending in .png .exr .pfm .hdr .pfs; do
    check "which names $ending" stderr_has "$ending"
done
expect_status 64 'rgbe is no ending' "$hdr" expose -o "$work/a.rgbe" "$picture"
expect_status 64 'a format and the ending of another' "$hdr" pfm -o "$work/a.hdr" "$picture"

# ---- The same bytes in one process, through a pipe, and behind a head --------------------------------------------

for file in "$work/a.hdr" "$work/a.pfs" "$work/a.pfm"; do
    for end in png exr rgbe pfs pfm; do
        name="${file##*/} to $end"
        expect_status 0 "$name" "$hdr" exp -q : "$end" -o - "$file"
        cp "$work/stdout" "$work/whole"
        "$hdr" exp -q : "$end" <"$file" >"$work/piped"
        check "$name: from standard input" cmp -s "$work/whole" "$work/piped"
        # shellcheck disable=SC2002 # a pipe is what is tried here
        cat "$file" | "$hdr" exp -q : "$end" | cat >"$work/piped"
        check "$name: through pipes" cmp -s "$work/whole" "$work/piped"
        "$hdr" exp "$file" | "$hdr" "$end" -q -j 1 >"$work/piped"
        check "$name: behind a head" cmp -s "$work/whole" "$work/piped"
    done
    "$hdr" exp "$file" | cat >"$work/head"
    check "${file##*/}: the head stands in front of its bytes" begins "$work/head" 'hdrpipe 1'
    tail -c "$(wc -c <"$file")" "$work/head" | cmp -s - "$file"
    check "${file##*/}: which are as they were" test $? -eq 0
done

# ---- What comes back ---------------------------------------------------------------------------------------------

"$hdr" pfm -q -o "$work/direct.pfm" "$picture"
expect_status 0 'PFM to PFM' "$hdr" pfm -o "$work/again.pfm" "$work/direct.pfm"
check 'PFM to PFM: the same bytes' cmp -s "$work/direct.pfm" "$work/again.pfm"
for end in '\n' '\r\n'; do
    # shellcheck disable=SC2059 # the bytes are the format
    printf "Pf${end}1 2${end}-1.0${end}\000\000\200\077\000\000\000\100" >"$work/lines.pfm"
    expect_status 0 "lines that end in $end" "$hdr" pfm -o - "$work/lines.pfm"
    cp "$work/stdout" "$work/lines"
    check "lines that end in $end: the pixels" test "$(tail -c 8 "$work/lines" | od -An -tf4 | tr -d ' \n')" = 12
    # shellcheck disable=SC2002 # a pipe is what is tried here
    cat "$work/lines.pfm" | "$hdr" pfm >"$work/piped"
    check "lines that end in $end: from a pipe" cmp -s "$work/lines" "$work/piped"
done
"$hdr" rgbe -o "$work/direct.hdr" "$picture"
expect_status 0 'HDR to HDR' "$hdr" rgbe -o "$work/again.hdr" "$work/direct.hdr"
check 'HDR to HDR: the same bytes' cmp -s "$work/direct.hdr" "$work/again.hdr"
"$hdr" pfs -o "$work/direct.pfs" "$picture"
expect_status 0 'PFS to PFS' "$hdr" pfs -o "$work/again.pfs" "$work/direct.pfs"
check 'PFS to PFS: the same bytes' cmp -s "$work/direct.pfs" "$work/again.pfs"
"$hdr" log : pfs -o "$work/grey.pfs" "$grey"
check 'a grey picture is written as X, Y and Z' test "$("$hdr" info "$work/grey.pfs" | grep -c '^  channels .*X float, Y float, Z float')" -eq 1
"$hdr" srgb : pfs -o "$work/encoded.pfs" "$picture"
expect_status 65 'an encoded PFS is not encoded again' "$hdr" srgb : png -o "$work/a.png" "$work/encoded.pfs"
"$hdr" png -o "$work/encoded.png" "$work/encoded.pfs"
"$hdr" pfs -o "$work/alpha.pfs" "$translucent"
check 'PFS has alpha' test "$("$hdr" info "$work/alpha.pfs" | grep -c '^  channels .*A float')" -eq 1
expect_status 0 'PFM of other primaries' "$hdr" pfm -o "$work/xyz.pfm" "$work/direct.pfs"
check 'PFM of other primaries: a note' stderr_has primaries
cat "$work/direct.pfs" "$work/grey.pfs" >"$work/frames.pfs"
expect_status 0 'two frames' "$hdr" pfs -o "$work/first.pfs" "$work/frames.pfs"
check 'two frames: a note' one_line_with 'first frame'
check 'two frames: the first is read' cmp -s "$work/direct.pfs" "$work/first.pfs"
mkfifo "$work/feed"
{ cat "$work/direct.pfs" && exec sleep 60; } >"$work/feed" &
feeder=$!
expect_status 0 'a frame whose pipe stays open' timeout 30 "$hdr" pfs -o "$work/first.pfs" "$work/feed"
kill $feeder
wait $feeder 2>/dev/null
check 'a frame whose pipe stays open: nothing to say' stderr_lines 0
head -c 3000 "$work/direct.pfs" >"$work/short.pfs"
expect_status 65 'a PFS that is cut off' "$hdr" png -o "$work/short.png" "$work/short.pfs"
check 'a PFS that is cut off: one line' one_line_with short.pfs

# ---- Pixels that are not square ----------------------------------------------------------------------------------

# shape FILE: what a PNG's pHYs chunk says: pixels across and down, the unit
shape() {
    at=$(LC_ALL=C grep -abo pHYs "$1" | cut -d: -f1)
    if [ -n "$at" ]; then od -An -v -tu1 -j$((at + 4)) -N9 "$1" | tr -s ' \n' ' '; fi
}
expect_status 0 'square pixels' "$hdr" png -o "$work/square.png" "$picture"
check 'square pixels: no word' test -z "$(shape "$work/square.png")"
cp "$picture" "$work/wide.exr"
at=$(LC_ALL=C grep -abo pixelAspectRatio "$work/wide.exr" | cut -d: -f1)
printf '\000\000\300\077' | dd of="$work/wide.exr" bs=1 seek=$((at + 27)) conv=notrunc 2>"$work/dd" # 1.5
for chain in png 'exp : png --bits 16' 'expose : png'; do
    # shellcheck disable=SC2086 # they are several words
    expect_status 0 "EXR, $chain" "$hdr" $chain -o "$work/wide.png" "$work/wide.exr"
    check "EXR, $chain: 2 across are as long as 3 down" test "$(shape "$work/wide.png")" = ' 0 0 0 2 0 0 0 3 0 '
done
sed '1,/^$/s/^FORMAT=/PIXASPECT=1.5\n&/' "$work/direct.hdr" >"$work/high.hdr"
expect_status 0 'Radiance HDR' "$hdr" png -o "$work/high.png" "$work/high.hdr"
check 'Radiance HDR: 3 across are as long as 2 down' test "$(shape "$work/high.png")" = ' 0 0 0 3 0 0 0 2 0 '

# ---- Other programs ----------------------------------------------------------------------------------------------

# within LIMIT A B: oiiotool finds no component further apart
within() {
    oiiotool --fail "$1" --warn "$1" --diff "$2" "$3" >"$work/difference" 2>&1
}

if command -v oiiotool >/dev/null; then
    "$hdr" exr -o "$work/read.exr" "$work/direct.hdr"
    check 'HDR: oiiotool reads the same' within 0 "$work/read.exr" "$work/direct.hdr"
    "$hdr" exr -o "$work/read.exr" "$work/direct.pfm"
    check 'PFM: oiiotool reads the same' within 0 "$work/read.exr" "$work/direct.pfm"
    oiiotool "$picture" --ch R,G,B -d float --rotate90 -o "$work/other.hdr" 2>"$work/stderr"
    "$hdr" exr -o "$work/read.exr" "$work/other.hdr"
    check "HDR of oiiotool's: the same" within 0 "$work/read.exr" "$work/other.hdr"
    corpus=${HDRPIPE_CORPUS:-../shared/corpus}
    if [ -d "$corpus/storage" ]; then
        for name in sample.hdr test.pfm; do
            "$hdr" exr -o "$work/read.exr" "$corpus/storage/$name"
            check "$name: oiiotool reads the same" within 0 "$work/read.exr" "$corpus/storage/$name"
        done
    else
        skip "there is no $corpus/storage"
    fi
else
    skip 'there is no oiiotool'
fi

to_pfsout() { "$hdr" pfs "$1" | pfsout "$2"; }
from_pfsin() { pfsin "$1" | "$hdr" rgbe -o "$2"; }
if command -v pfsin >/dev/null && command -v pfsout >/dev/null && command -v oiiotool >/dev/null; then
    "$hdr" clamp --max 100 : exr -o "$work/light.exr" "$picture"
    # the matrix of pfstools has four decimals
    expect_status 0 'hdr | pfsout' to_pfsout "$work/light.exr" "$work/out.pfm"
    check 'hdr | pfsout: the same picture' within 0.02 "$work/out.pfm" "$work/light.exr"
    "$hdr" pfm -q -o "$work/light.pfm" "$work/light.exr"
    expect_status 0 'pfsin | hdr' from_pfsin "$work/light.pfm" "$work/in.hdr"
    "$hdr" rgbe -o "$work/light.hdr" "$work/light.exr"
    check 'pfsin | hdr: the same picture' within 0.51 "$work/in.hdr" "$work/light.hdr"
    pfsin "$work/light.pfm" | "$hdr" log | "$hdr" png >"$work/a.png"
    "$hdr" log : png -o "$work/b.png" "$work/light.exr"
    oiiotool --fail 0.005 --diff "$work/a.png" "$work/b.png" >/dev/null
    check 'pfsin | hdr log | hdr png: at most a code apart' test $? -eq 0
    pfsin "$work/light.pfm" | pfsgamma -g 2.2 | "$hdr" png >"$work/a.png"
    "$hdr" gamma -g 2.2 : png -o "$work/b.png" "$work/light.exr"
    oiiotool --fail 0.005 --diff "$work/a.png" "$work/b.png" >"$work/difference"
    check 'pfsgamma | hdr png: it is not encoded again' test $? -eq 0
else
    skip 'there is no pfstools, or no oiiotool'
fi

# a grey file of which colours are made
"$hdr" pfm -o "$work/grey.pfm" "$grey"
"$hdr" exr -o "$work/grey.exr" "$work/grey.pfm"
for verb in falsecolour ocio 'png --alpha over:1,0,0'; do
    # shellcheck disable=SC2086 # words
    expect_status 0 "grey PFM in colours, $verb" "$hdr" $verb -q -o "$work/coloured.png" "$work/grey.pfm"
    # shellcheck disable=SC2086 # words
    "$hdr" $verb -q -o "$work/wanted.png" "$work/grey.exr"
    check "grey PFM in colours, $verb: as from EXR" cmp -s "$work/coloured.png" "$work/wanted.png"
done

finish test_formats

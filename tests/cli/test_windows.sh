#!/bin/sh
# Display windows smaller than the data window: what lies outside is not looked at where nothing depends on it, and is
# where something does.
. tests/cli/lib.sh

same_bytes() {
    cmp -s "$1" "$2"
}

# show FILE X0 Y0 X1 Y1: makes that the file's display window.
show() {
    at=$(LC_ALL=C grep -abo displayWindow "$1" | cut -d: -f1)
    # shellcheck disable=SC2059 # the bytes are the format
    printf "$(little "$2")$(little "$3")$(little "$4")$(little "$5")" |
        dd of="$1" bs=1 seek=$((at + 24)) conv=notrunc 2>"$work/dd"
}

colour_type() {
    od -An -tu1 -j25 -N1 "$1" | tr -d ' '
}

# ---- A picture in colour whose upper part is outside the frame, and damaged ----

"$hdr" exr --compression zip --type half -o "$work/whole.exr" testdata/interior.exr
size=$("$hdr" info --json "$work/whole.exr" | sed 's/.*"width": \([0-9]*\), "height": \([0-9]*\).*/\1 \2/')
width=${size% *} height=${size#* }
show "$work/whole.exr" 0 $((height / 2)) $((width - 1)) $((height - 1))
cp "$work/whole.exr" "$work/damaged.exr"
chunks=$(((height + 15) / 16))
header=$(LC_ALL=C grep -abo screenWindowWidth "$work/whole.exr" | cut -d: -f1)
# behind the table, behind the first chunk's leader: bytes that no deflate stream begins with
printf '\377\377\377\377\377\377\377\377' |
    dd of="$work/damaged.exr" bs=1 seek=$((header + 8 * chunks + 400)) conv=notrunc 2>"$work/dd"
expect_status 65 'the damage is where a picture is' "$hdr" clamp : png --window data -o "$work/a.png" "$work/damaged.exr"
expect_status 0 'all of it' "$hdr" clamp : png --no-skip -o "$work/all.png" "$work/whole.exr"
for chain in 'clamp : png' 'clamp : exr' 'srgb : png --bits 16' 'clamp : pfm'; do
    # shellcheck disable=SC2086 # they are several words
    {
        "$hdr" $chain --no-skip -o - "$work/whole.exr" >"$work/all"
        "$hdr" $chain -o - "$work/damaged.exr" >"$work/part"
        check "$chain: what is shown does not depend on what is not" same_bytes "$work/all" "$work/part"
        "$hdr" $chain -o - <"$work/damaged.exr" >"$work/part"
        check "$chain: nor from standard input" same_bytes "$work/all" "$work/part"
        expect_status 65 "$chain: --strict looks at all" "$hdr" $chain --strict -o "$work/x" "$work/damaged.exr"
        expect_status 65 "$chain: --no-skip looks at all" "$hdr" $chain --no-skip -o "$work/x" "$work/damaged.exr"
    }
done
expect_status 65 'facts are of all' "$hdr" log : png -o "$work/a.png" "$work/damaged.exr"

# ---- Grey where it is shown, coloured in one row that is not ----

grey='\000\000\000\077\000\000\000\077\000\000\000\077'
{
    printf 'PF\n1 64\n-1.0\n'
    row=0
    while [ $row -lt 64 ]; do
        # shellcheck disable=SC2059 # the bytes are the format
        if [ $row -eq 62 ]; then printf '\000\000\000\077\000\000\000\000\000\000\000\077'; else printf "$grey"; fi
        row=$((row + 1))
    done
} >"$work/rows.pfm"
"$hdr" exr --compression zips -o "$work/rows.exr" "$work/rows.pfm"
show "$work/rows.exr" 0 8 0 63
expect_status 0 'grey rows' "$hdr" clamp : png -o "$work/rows.png" "$work/rows.exr"
check 'a colour outside the frame makes no grey picture' test "$(colour_type "$work/rows.png")" = 2
expect_status 0 'grey rows, all' "$hdr" clamp : png --no-skip -o "$work/all.png" "$work/rows.exr"
check 'the same bytes' same_bytes "$work/rows.png" "$work/all.png"

# a NaN, repaired to the black beside it, is no colour, though its bits are others
"$hdr" exr --compression none -o "$work/nan.exr" "$work/rows.pfm"
show "$work/nan.exr" 0 8 0 63
first=$(($(wc -c <"$work/nan.exr") - 64 * 20))
row=0
while [ $row -lt 64 ]; do # B, G and R behind each row's leader of 8 bytes
    if [ $row -eq 32 ]; then pixel='\000\000\000\000\000\000\000\000\000\000\300\177'; else pixel=$grey; fi
    # shellcheck disable=SC2059 # the bytes are the format
    printf "$pixel" | dd of="$work/nan.exr" bs=1 seek=$((first + row * 20 + 8)) conv=notrunc 2>"$work/dd"
    row=$((row + 1))
done
expect_status 0 'a NaN' "$hdr" clamp : png -o "$work/nan.png" "$work/nan.exr"
check 'it was repaired' stderr_has '1 NaN'
expect_status 0 'a NaN, all looked at' "$hdr" clamp : png --no-skip -o "$work/all.png" "$work/nan.exr"
check 'a NaN makes no colour' test "$(colour_type "$work/nan.png")" = 0
check 'the same bytes with a NaN' same_bytes "$work/nan.png" "$work/all.png"

finish test_windows

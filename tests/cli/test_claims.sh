#!/bin/sh
# Headers that claim more than there is, or that do not end: told at once, with little memory, whatever is behind them.
. tests/cli/lib.sh

compile_measure
mkdir "$work/out"

from_file() { timeout 10 "$work/measure" "$work/used" "$hdr" "$@"; }
piped() { timeout 10 "$work/measure" "$work/used" "$hdr" "$@" <"$work/pipe"; }
picture_from_file() { from_file "$@" -o "$work/out/a" "$claim"; }
picture_piped() { # not as a whole: a reader that takes all of it is to be seen
    rm -f "$work/pipe"
    mkfifo "$work/pipe"
    head -c 100000000 "$claim" >"$work/pipe" 2>"$work/head_stderr" &
    piped "$@" -o "$work/out/a"
    piped_status=$?
    wait
    return $piped_status
}

# quick NAME: what was measured last took less than 2 s and 64 MB (a sanitizer has its own)
most=65536
if nm "$hdr" 2>/dev/null | grep -q __asan_init; then most=262144; fi
quick() {
    kilobytes=999999999 milliseconds=999999999
    if [ -s "$work/used" ]; then read -r kilobytes milliseconds <"$work/used"; fi
    check "$1: $kilobytes KB" test "$kilobytes" -lt "$most"
    check "$1: $milliseconds ms" test "$milliseconds" -lt 2000
    rm -f "$work/used" "$work/out/a"
}

# refused WORD COMMAND...: 65, a line with the word, nothing written, quickly
refused() {
    word=$1
    shift
    expect_status 65 "$*" "$@"
    check "$*: one line with $word" one_line_with "$word"
    check "$*: nothing is written" empty_directory "$work/out"
    quick "$*"
}

# ---- EXR files of 16 x 2^27-1 pixels, of which there is none -----------------------------------------------------

# attribute NAME TYPE VALUE: the value as printf is to write it, of which each byte is four characters.
attribute() {
    # shellcheck disable=SC2059 # the bytes are the format
    printf "$1\\0$2\\0$(little $((${#3} / 4)))$3"
}

# claim_exr COMPRESSION TILED CHANNEL...: the header, and so many zeros behind it that there could be a chunk table.
claim_exr() {
    window=$(little 0)$(little 0)$(little 15)$(little $((0x7fffffe)))
    compression=$1 tiled=$2 channels=
    shift 2
    for channel in "$@"; do # half, not subsampled
        channels="$channels$(printf '\\%03o' "'$channel")\\000$(little 1)$(little 0)$(little 1)$(little 1)"
    done
    {
        # shellcheck disable=SC2059 # the bytes are the format
        printf "\\166\\057\\061\\001\\002\\00$((tiled * 2))\\000\\000"
        attribute channels chlist "$channels\\000"
        attribute compression compression "\\00$compression"
        attribute dataWindow box2i "$window"
        attribute displayWindow box2i "$window"
        attribute lineOrder lineOrder '\000'
        attribute pixelAspectRatio float '\000\000\200\077'
        attribute screenWindowCenter v2f "$(little 0)$(little 0)"
        attribute screenWindowWidth float '\000\000\200\077'
        if [ "$tiled" = 1 ]; then attribute tiles tiledesc "$(little 16)$(little 1)\\000"; fi
        printf '\000'
    } >"$claim"
    header=$(wc -c <"$claim")
    dd if=/dev/null of="$claim" bs=1 seek=1100000000 2>"$work/dd"
}

# point OFFSET: the first entry of the chunk table.
point() {
    # shellcheck disable=SC2059 # the bytes are the format
    printf "$(little "$1")" | dd of="$claim" bs=1 seek="$header" conv=notrunc 2>"$work/dd"
}

claim=$work/claim.exr
for kind in '3 0' '0 0' '3 1'; do
    for names in 'B G R' Y; do
        # shellcheck disable=SC2086 # they are several words
        claim_exr $kind $names
        expect_status 0 "EXR $kind $names: it is a header" "$hdr" info "$claim"
        check "EXR $kind $names: of that size" grep -q '^  data window  *16 x 134217727 ' "$work/stdout"
        for end in png exr pfm rgbe; do
            refused 'they are missing' picture_from_file clamp : $end --memory 1M
        done
        refused 'they are missing' picture_from_file png
        refused 'they are missing' picture_from_file log : png
        refused 'from a pipe' picture_piped clamp : png --memory 1M
    done
done
# the first chunk where there can be none, and where there is another's: the rows are told, and none behind them visited
for place in 5 1200000000 1099999990 1000000000; do
    point $place
    refused 'rows 0 to 0, tile 0: ' picture_from_file clamp : png --memory 1M
done
# --crop needs the entries of its own rows only
claim_exr 3 0 Y
refused 'rows 99999984 to 99999999: they are missing' picture_from_file clamp : png --crop 0,99999990,16,3

# ---- Headers of text ---------------------------------------------------------------------------------------------

# letters COUNT: as many of the letter a.
letters() {
    head -c "$1" /dev/zero | tr '\0' a
}

claim=$work/claim.hdr
pixels() { printf '\n-Y 1 +X 1\n\200\200\200\201'; }
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n#' && letters 65535 && printf '\n' && pixels; } >"$claim"
expect_status 0 'a line of 64 KiB' "$hdr" png -o "$work/a.png" "$claim"
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n#' && letters 65536 && printf '\n' && pixels; } >"$claim"
refused 'a line is too long' picture_from_file png
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n' && letters 1000000 | fold -w 100 && printf '\n' && pixels; } >"$claim"
expect_status 0 'a header of a megabyte' "$hdr" png -o "$work/a.png" "$claim"
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n' && letters 1048576 | fold -w 100 && printf '\n' && pixels; } >"$claim"
refused 'it is longer than 1 MiB' picture_from_file png

# what has no end, up to 100 MB
for first in '#?RADIANCE\n' '#?'; do
    # shellcheck disable=SC2059 # the words hold an end of line
    { printf "$first" && letters 100000000; } >"$claim"
    refused 'a line is too long' picture_from_file png
    refused 'a line is too long' picture_piped png
    refused 'a line is too long' from_file info "$claim"
done
{ printf '#?RADIANCE\n' && letters 100000000 | fold -w 60000; } >"$claim"
refused 'it is longer than 1 MiB' picture_from_file png
refused 'it is longer than 1 MiB' picture_piped png

claim=$work/claim.pfs
pfs() {
    printf 'PFS1\n1 1\n1\n%d\n' "$1"
    letters $(($1 * 2000)) | fold -w 2000 | sed 's/^a/a=/'
    printf '\nY\n0\nENDH\0\0\200\077'
}
pfs 500 >"$claim"
expect_status 0 'PFS: a megabyte of tags' "$hdr" png -o "$work/a.png" "$claim"
pfs 1000 >"$claim"
refused 'it is longer than 1 MiB' picture_from_file png
for first in 'PFS1\n' 'PFS1\n1 1\n1\n1\na='; do
    # shellcheck disable=SC2059 # the words hold ends of lines
    { printf "$first" && letters 100000000; } >"$claim"
    refused 'a line is too long' picture_piped png
done
claim=$work/claim.pfm
{ printf 'PF\n' && letters 100000000; } >"$claim"
refused 'PFM begins with' picture_piped png
refused 'PFM begins with' picture_from_file png

finish test_claims

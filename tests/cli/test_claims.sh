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

finish test_claims

#!/bin/sh
# DWAA and DWAB: written and read through the plug-in, which is loaded for them alone, and is missed in a sentence.
. tests/cli/lib.sh

plug_in=$BUILD/plugin/hdrpipe-exr.so
elsewhere=$work/elsewhere
mkdir -p "$elsewhere/plugin" "$work/out"
cp "$hdr" "$elsewhere/hdr" || exit 1

# ---- Without the plug-in -------------------------------------------------------------------------------------------

# missed NAME WORD COMMAND...: one line that says what is missing, and nothing is written
missed() {
    name=$1 word=$2
    shift 2
    expect_status 65 "$name" "$@"
    check "$name: one line" stderr_lines 1
    check "$name: says '$word'" stderr_has "$word"
    check "$name: names the package" stderr_has libopenexr-3-1-30
    check "$name: nothing is written" empty_directory "$work/out"
}
# named by the header alone: the compression's number is 8 (DWAA) instead of 3 (ZIP)
"$hdr" exr --compression zip -o "$work/zip.exr" testdata/glossy.exr || exit 1
at=$(grep -abo 'compression.compression' "$work/zip.exr" | head -n 1 | cut -d : -f 1)
cp "$work/zip.exr" "$work/claims_dwaa.exr"
printf '\010' | dd of="$work/claims_dwaa.exr" bs=1 seek=$((at + 28)) conv=notrunc 2>"$work/log"
if "$elsewhere/hdr" exr --compression dwaa -o "$work/a.exr" testdata/glossy.exr 2>"$work/stderr"; then
    skip 'a plug-in is installed where all programs look for it'
else
    missed 'reading without the plug-in' claims_dwaa.exr "$elsewhere/hdr" png -o "$work/out/a.png" "$work/claims_dwaa.exr"
    check 'it names the compression' stderr_has DWAA
    missed 'writing without the plug-in' a.exr "$elsewhere/hdr" exr --compression dwab -o "$work/out/a.exr" testdata/glossy.exr
    check 'it names the compression' stderr_has DWAB
    echo 'no program' >"$elsewhere/plugin/hdrpipe-exr.so"
    missed 'a plug-in that is none' 'cannot be loaded' "$elsewhere/hdr" png -o "$work/out/a.png" "$work/claims_dwaa.exr"
    echo 'const int hdr_dwa = 0;' >"$work/other.c"
    # shellcheck disable=SC2086 # CC may hold options
    if $CC -shared -fPIC -o "$elsewhere/plugin/hdrpipe-exr.so" "$work/other.c" 2>"$work/log"; then
        expect_status 65 'a plug-in of another interface' "$elsewhere/hdr" png -o "$work/out/a.png" "$work/claims_dwaa.exr"
        check 'it says so' stderr_has 'another version'
    else
        skip 'no shared object can be made'
    fi
fi
expect_status 0 'other files need no plug-in' "$elsewhere/hdr" png -o "$work/a.png" "$work/zip.exr"
expect_status 0 'the header of one needs none' "$elsewhere/hdr" info "$work/claims_dwaa.exr"
check 'it tells the compression' grep -q dwaa "$work/stdout"

# ---- The command line ----------------------------------------------------------------------------------------------

expect_status 64 'a level for zip' "$hdr" exr --dwa-level 45 -o "$work/out/a.exr" testdata/glossy.exr
expect_status 64 'a level below 0' "$hdr" exr --compression dwaa --dwa-level -1 -o "$work/out/a.exr" testdata/glossy.exr
check 'nothing is written' empty_directory "$work/out"

if ! [ -e "$plug_in" ]; then
    skip "there is no $plug_in: no C++ compiler, or no C++ headers of OpenEXR"
    finish test_dwa
    exit
fi

# ---- With it -------------------------------------------------------------------------------------------------------

if ! grep -q fsanitize "$BUILD/flags" && command -v readelf >/dev/null && readelf -d "$hdr" >"$work/libraries" 2>/dev/null; then
    check 'hdr links OpenEXR in C' grep -q 'NEEDED.*libOpenEXRCore' "$work/libraries"
    check 'hdr links no C++' test "$(grep -cE 'NEEDED.*(libstdc\+\+|libc\+\+|libOpenEXR-)' "$work/libraries")" -eq 0
fi
for file in "$work/zip.exr" "$work/claims_dwaa.exr"; do
    LD_DEBUG=files "$hdr" png -q -o "$work/a.png" "$file" >"$work/loaded" 2>&1
    grep -c 'calling init.*hdrpipe-exr' "$work/loaded" >"$work/count"
    case $file in
    */zip.exr) check 'the plug-in is not loaded for other files' test "$(cat "$work/count")" -eq 0 ;;
    *) if grep -q 'calling init' "$work/loaded"; then
        check 'it is loaded for such a file' test "$(cat "$work/count")" -ge 1
    fi ;;
    esac
done
expect_status 65 'zip data that claims to be DWAA' "$hdr" png -o "$work/out/a.png" "$work/claims_dwaa.exr"
check 'it names rows' stderr_has row
check 'nothing is written' empty_directory "$work/out"

for compression in dwaa dwab; do
    for picture in testdata/glossy.exr testdata/tiny/*.exr; do
        name="${picture##*/} $compression"
        written=$work/written.exr
        expect_status 0 "$name: written" "$hdr" exr -q --type half --compression $compression -j 1 -o "$written" "$picture"
        expect_status 0 "$name: written by two" "$hdr" exr -q --type half --compression $compression -j 2 -o "$work/two.exr" "$picture"
        check "$name: the same bytes" cmp -s "$written" "$work/two.exr"
        expect_status 0 "$name: its header" "$hdr" info "$written"
        check "$name: it says so" grep -q "scan-line, $compression" "$work/stdout"
        check "$name: it holds the level" grep -qa dwaCompressionLevel "$written"
        expect_status 0 "$name: read" "$hdr" log : png -o "$work/file.png" "$written"
        # shellcheck disable=SC2002 # a pipe is what is tested
        cat "$written" | "$hdr" log : png >"$work/pipe.png" 2>"$work/stderr"
        check "$name: from a pipe the same" cmp -s "$work/file.png" "$work/pipe.png"
    done
    "$hdr" exr --compression $compression -o "$work/small.exr" testdata/interior.exr
    "$hdr" exr --compression $compression --dwa-level 500 -o "$work/smaller.exr" testdata/interior.exr
    check "$compression: smaller than zip" test "$(wc -c <"$work/small.exr")" -lt "$("$hdr" exr testdata/interior.exr | wc -c)"
    check "$compression: smaller at a higher level" test "$(wc -c <"$work/smaller.exr")" -lt "$(wc -c <"$work/small.exr")"
done

finish test_dwa

#!/bin/sh
# Every EXR that is read gives the values that OpenEXR's C++ library reads: tests/oracle/compare_exr.cc compares them.
. tests/cli/lib.sh

compare=$BUILD/tests/oracle/compare_exr
corpus=${HDRPIPE_CORPUS:-../shared/corpus}
if ! [ -x "$compare" ]; then
    skip "there is no $compare: no C++ compiler, or no C++ headers of OpenEXR"
    finish test_exr_library
    exit
fi

# same FILE: both read the same
same() {
    expect_status 0 "${1##*/}" "$compare" "$hdr" "$work/scratch" "$1"
    if [ "$status" -ne 0 ]; then cat "$work/stdout"; fi
}

for file in testdata/*.exr testdata/tiny/*.exr; do same "$file"; done

# ---- The test itself -------------------------------------------------------------------------------------------------

# a program that gives another picture than it is asked for, and one that gives none
# shellcheck disable=SC2016 # they are for the programs
printf '#!/bin/sh\nexec "%s" exr --compression none -q -o "$8" testdata/glossy.exr\n' "$hdr" >"$work/other"
# shellcheck disable=SC2016 # they are for the programs
printf '#!/bin/sh\nexec "%s" expose --ev 0.001 : exr --compression none -q -o "$8" "$9"\n' "$hdr" >"$work/near"
chmod +x "$work/other" "$work/near"
expect_status 1 'another picture is noticed' "$compare" "$work/other" "$work/scratch" testdata/interior.exr
expect_status 1 'other values are noticed' "$compare" "$work/near" "$work/scratch" testdata/interior.exr
expect_status 2 'no picture is noticed' "$compare" false "$work/scratch" testdata/interior.exr

# ---- Pictures of others --------------------------------------------------------------------------------------------

photo=testdata/interior.exr
not_read='deep_trunks Flowers Rec709_YC XYZ_YC beachball_multipart'
if [ -d "$corpus" ]; then
    photo=$corpus/photo/Desk.exr
    for file in "$corpus"/photo/*.exr "$corpus"/render/*.exr "$corpus"/windows/*.exr "$corpus"/torture/*.exr \
        "$corpus"/storage/*.exr; do
        name=${file##*/}
        case " $not_read " in
        *" ${name%.exr} "*)
            "$compare" "$hdr" "$work/scratch" "$file" >"$work/stdout" 2>"$work/stderr"
            check "$name: not read, or the same" test $? -ne 1
            ;;
        *) same "$file" ;;
        esac
    done
else
    skip "there is no $corpus"
fi

# ---- Every compression, type and storage ---------------------------------------------------------------------------

plug_in=$BUILD/plugin/hdrpipe-exr.so
for compression in none rle zips zip piz pxr24 b44 b44a dwaa dwab; do
    case $compression in
    dwa*) if ! [ -e "$plug_in" ]; then
        skip "$compression: there is no $plug_in"
        continue
    fi ;;
    esac
    for type in half float; do
        lines=$work/${compression}_$type.exr tiles=$work/${compression}_${type}_tiles.exr
        expect_status 0 "$compression, $type" "$hdr" exr --type "$type" --compression "$compression" -o "$lines" "$photo"
        same "$lines"
        if [ "$compression" = zips ]; then
            : # exrmaketiled does not know it: below
        elif ! command -v exrmaketiled >/dev/null; then
            skip "$compression, $type, tiled: exrmaketiled is not there"
        else
            for levels in -o -m; do
                check "$tiles" exrmaketiled $levels -t 48 40 -z "$compression" "$lines" "$tiles"
                same "$tiles"
            done
        fi
        rm -f "$lines" "$tiles"
    done
done

# half and float in one file
if command -v oiiotool >/dev/null; then
    for compression in zips zip piz pxr24 b44 b44a dwaa dwab; do
        case $compression in
        dwa*) [ -e "$plug_in" ] || continue ;;
        esac
        for storage in --scanline '--tile 48 40'; do
            # shellcheck disable=SC2086 # an option and its values
            check "$compression, mixed" oiiotool "$photo" -d half -d G=float $storage --compression "$compression" \
                -o "$work/mixed.exr"
            same "$work/mixed.exr"
        done
    done
else
    skip 'oiiotool is not there'
fi

finish test_exr_library

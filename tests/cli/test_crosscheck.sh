#!/bin/sh
# crosscheck: every curve agrees with OpenColorIO's and with what is published, and a constant that is wrong in its last
# digit is found.
. tests/cli/lib.sh

expect_status 64 'a picture' "$hdr" crosscheck testdata/glossy.exr
expect_status 64 'behind a chain' "$hdr" log : crosscheck
expect_status 64 'a verb without a curve' "$hdr" crosscheck --only log
expect_status 64 'a word that is no verb' "$hdr" crosscheck --only nonesuch
if ! [ -e "$BUILD/plugin/hdrpipe-ocio.so" ]; then
    expect_status 65 'without the plug-in' "$hdr" crosscheck
    skip 'there is no plug-in: no C++ compiler, or no headers of OpenColorIO'
    finish test_crosscheck
    exit
fi

# ---- All of it -----------------------------------------------------------------------------------------------------

expect_status 0 'all lines agree' "$hdr" crosscheck
sed 1,3d "$work/stdout" >"$work/lines"
check 'there are lines' test -s "$work/lines"
while read -r line; do
    check "$line" test -n "$(printf '%s\n' "$line" | grep ' agrees')"
done <"$work/lines"
# a filter that can decode is an encoding: both ways are compared
for verb in $(verbs_of_kind filter); do
    "$hdr" help --options "$verb" | grep -qx -- --decode || continue
    check "$verb is compared" grep -q "^$verb .* agrees" "$work/lines"
    check "$verb --decode is compared" grep -q "^$verb .*--decode .* agrees" "$work/lines"
done
# the table that is kept: the same lines, with the same verdicts and reasons; digits may depend on the C library
verdicts() { sed -E 's/^(.{31}).*(agrees|DIFFERS)/\1\2/' "$1"; }
verdicts "$work/stdout" | sed 1,3d >"$work/verdicts"
verdicts tests/oracle/crosscheck.txt | sed 1,3d >"$work/kept"
check 'the table that is kept has the same lines' cmp -s "$work/verdicts" "$work/kept"
expect_status 0 'as JSON' "$hdr" crosscheck --only primaries --json
check 'one object a line' test "$(grep -c '^{"what": .*"agrees": true}$' "$work/stdout")" -eq "$(wc -l <"$work/stdout")"

# ---- A wrong digit is found ----------------------------------------------------------------------------------------

# a program whose verb, or colour, is compiled anew from a source that was changed; it finds the plug-in beside itself
mkdir -p "$work/other"
ln -s "$BUILD/plugin" "$work/other/plugin"
flags=$(sed -n 's/.*-fsanitize=\([^ ]*\).*/-fsanitize=\1/p' "$BUILD/flags" | head -n 1)
# finds SOURCE ONLY BEFORE AFTER: the first that stands there becomes the other
finds() {
    source=$1 only=$2
    sed "s|$3|$4|" "$source" >"$work/other/changed.c"
    if cmp -s "$source" "$work/other/changed.c"; then
        fail "$source: there is no $3"
        return
    fi
    # shellcheck disable=SC2086 # CC and the flags are words
    $CC -std=c11 -D_GNU_SOURCE -O1 -ffp-contract=off $flags -pthread -Iinclude -Isrc -o "$work/other/hdr" "$work/other/changed.c" \
        "$BUILD"/cmd/*.o "$BUILD/libhdrpipe.a" -lOpenEXRCore -lpng -ldeflate -lisal -lz -lm >"$work/log" 2>&1
    check "$source compiles with $4" test $? -eq 0
    expect_status 1 "$source: $4 instead of $3 is found" "$work/other/hdr" crosscheck --only "$only"
    rm -f "$work/other/hdr"
}
srgb() { finds src/verb/srgb.c srgb "$@"; }
srgb 'JOINT 0.0031308' 'JOINT 0.0031309'
srgb '12.92 \* c :' '12.93 * c :'
srgb '1.055 \* hdr' '1.056 * hdr'
srgb ' - 0.055;' ' - 0.056;'
srgb '1 / 2.4' '1 / 2.5'
srgb '<= 0.04045;' '<= 0.04046;'
srgb '+ 0.055) / 1.055, 2.4' '+ 0.056) / 1.055, 2.4'
srgb '+ 0.055) / 1.055, 2.4' '+ 0.055) / 1.056, 2.4'
srgb '1.055, 2.4' '1.055, 2.5'
srgb 'c / 12.92 :' 'c / 12.93 :'
rec709() { finds src/verb/rec709.c rec709 "$@"; }
rec709 'c < 0.018;' 'c < 0.019;'
rec709 '1.099 \* hdr' '1.100 * hdr'
rec709 'above, 0.45' 'above, 0.46'
rec709 ' - 0.099;' ' - 0.100;'
rec709 '4.5 \* c :' '4.6 * c :'
rec709 'c < 0.081;' 'c < 0.082;'
rec709 '/ 1.099, 1' '/ 1.100, 1'
rec709 'c / 4.5 :' 'c / 4.6 :'
finds src/verb/pq.c pq '(2610.0 /' '(2611.0 /'
finds src/verb/pq.c pq '(2523.0 ' '(2524.0 '
finds src/verb/pq.c pq 'C1_4096 = 3424, C2_4096 = 2413' 'C1_4096 = 3392, C2_4096 = 2414'
hlg() { finds src/verb/hlg.c hlg "$@"; }
hlg '0.17883277$' '0.17883278'
hlg '0.28466892$' '0.28466893'
hlg '0.559910729529562$' '0.559910729529563'
primaries() { finds src/picture/colour.c primaries "$@"; }
primaries '0.2126, 0' '0.2127, 0'
primaries '0.0722}' '0.0723}'
primaries '{0.64, 0' '{0.65, 0'
primaries '{0.3127, 0' '{0.3128, 0'
primaries '0.8951,' '0.8952,'
primaries '1.0296}' '1.0297}'
finds src/verb/gamma.c gamma ': 1 / g' ': 1 / (g + 1e-9)'

finish test_crosscheck

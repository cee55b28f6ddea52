#!/bin/sh
# src/verb/skeleton.c and one line in the list of verbs make a verb, everywhere: nothing else has to know of it.
. tests/cli/lib.sh

picture=testdata/glossy.exr

# ---- hdr with the skeleton in it ---------------------------------------------------------------------------------

cp src/verb/verbs.def "$work/verbs.def"
# before the first encoding, so that it is not the last of the list
sed -i 's/^HDR_VERB(gamma)$/HDR_VERB(skeleton)\n&/' "$work/verbs.def"
check 'one line more' test "$(grep -c '^HDR_VERB(skeleton)$' "$work/verbs.def")" -eq 1
check 'the library is without it' test -z "$("$hdr" help --list | grep skeleton)"

# The build's own compiler and flags, up to those for the linker.
read -r flags <"$BUILD/flags"
flags=${flags%%-pthread*}
compile() {
    # shellcheck disable=SC2086 # words
    $flags -pthread -Wall -Wextra -Werror -Iinclude -Isrc "$@"
}
check 'the skeleton compiles without a warning' compile -c src/verb/skeleton.c -o "$work/skeleton.o"
check 'the registry compiles' compile "-DHDR_VERBS_DEF=\"$work/verbs.def\"" -c src/verb/registry.c -o "$work/registry.o"
# objects come before the library, whose own registry is not taken then
check 'they link' compile "$BUILD"/cmd/*.o "$work/registry.o" "$work/skeleton.o" "$BUILD/libhdrpipe.a" \
    -lOpenEXRCore -lpng -ldeflate -lisal -lz -lm -o "$work/hdr"
if ! [ -x "$work/hdr" ]; then
    finish test_skeleton
    exit
fi
skeleton=$work/hdr

# ---- It is a verb like the others --------------------------------------------------------------------------------

expect_status 0 'help' "$skeleton" skeleton --help
check 'help has its option' grep -q -- '-a, --amount A .*(0 to 1; default 0.5)' "$work/stdout"
check 'help has its other option' grep -q -- '--to VALUE .*(-65504 to 65504 or max; default 1)' "$work/stdout"
expect_status 0 'list' "$skeleton" help --list
check 'the list has it' grep -q '^skeleton	filter	fade' "$work/stdout"
check 'the list has the others' test "$(wc -l <"$work/stdout")" -eq "$(($("$hdr" help --list | wc -l) + 1))"
expect_status 0 'the manual' "$skeleton" help --man skeleton
check 'the manual has its option' grep -q '^\.It Fl a , Fl Fl amount Ar' "$work/stdout"
expect_status 64 'an amount out of range' "$skeleton" skeleton --amount 1.5 "$picture"
check 'its help line is shown' stderr_has '-a, --amount A'
expect_status 64 'a word of no meaning' "$skeleton" skeleton --to min "$picture"
expect_status 64 'an option that it has not' "$skeleton" skeleton --exponent 2 "$picture"
ln -s hdr "$work/hdr-skeleton"
expect_status 0 'under its own name' "$work/hdr-skeleton" -o "$work/own.png" "$picture"
expect_status 0 'as the first word' "$skeleton" skeleton -o "$work/word.png" "$picture"
check 'both give the same' cmp -s "$work/own.png" "$work/word.png"

# ---- It computes -------------------------------------------------------------------------------------------------

# values OPTION...: the components of a picture of nothing but 0.5, after the skeleton, each value once
values() {
    "$skeleton" skeleton "$@" : pfm -o "$work/a.pfm" testdata/tiny/constant.exr
    tail -c $((8 * 8 * 3 * 4)) "$work/a.pfm" | od -An -v -tf4 -w4 | sort -u | tr -d ' \n'
}
check 'half way to 1' test "$(values)" = 0.75
check 'a quarter of the way' test "$(values -a 0.25)" = 0.625
check 'all the way' test "$(values --amount 1 --to 7)" = 7
check 'no way' test "$(values --amount=0)" = 0.5
check 'away from it' test "$(values -a0.5 --to -1.5)" = -0.5
check 'to the maximum, which is there already' test "$(values --to max)" = 0.5
after_another() { "$skeleton" expose --ev 2 : skeleton -a 0.5 --to max : pfm -o "$work/a.pfm" "$1"; }
expect_status 0 'behind another verb' after_another testdata/tiny/ramp.exr
# the ramp's largest component is 1, 4 here; the smallest is 0, half way up then
extremes=$(tail -c $((16 * 4 * 3 * 4)) "$work/a.pfm" | od -An -v -tf4 -w4 | sort -g | sed -n '1p;$p' | tr -d ' ' | tr '\n' ' ')
check 'facts are those behind that verb' test "$extremes" = '2 4 '

# ---- The laws hold for it ----------------------------------------------------------------------------------------

as_words() { "$skeleton" skeleton -a 0.25 --to max : srgb : png "$@" "$picture"; }
as_pipe() { "$skeleton" skeleton -a 0.25 --to max "$picture" | "$skeleton" srgb | "$skeleton" png; }
expect_status 0 'in a chain' as_words -o "$work/words.png"
expect_status 0 'in a pipe' as_pipe
check 'a pipe gives the same bytes' cmp -s "$work/stdout" "$work/words.png"
for option in -j1 -j3 --reference --no-skip --memory=1M; do
    expect_status 0 "$option" as_words "$option" -o "$work/other.png"
    check "$option gives the same bytes" cmp -s "$work/words.png" "$work/other.png"
done
for cpu in c sse2 avx2 avx512; do
    expect_status 0 "HDR_CPU=$cpu" env HDR_CPU=$cpu "$skeleton" skeleton -a 0.25 --to max : srgb : png -o "$work/other.png" "$picture"
    check "HDR_CPU=$cpu gives the same bytes" cmp -s "$work/words.png" "$work/other.png"
done
expect_status 0 'the plan' as_words --explain -o "$work/other.png"
check 'the plan tells its note' stderr_has '(skeleton): 0.25 of the way to '
newer_program() { "$skeleton" skeleton "$picture" | "$hdr" png; }
expect_status 65 'a head from a newer program' newer_program
check 'the verb is named' one_line_with "unknown verb 'skeleton'"

finish test_skeleton

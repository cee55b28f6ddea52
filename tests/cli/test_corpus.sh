#!/bin/sh
# Real pictures, odd ones and damaged ones. They are no part of the project: skipped where they are absent.
. tests/cli/lib.sh

corpus=${HDRPIPE_CORPUS:-../shared/corpus}
if ! [ -d "$corpus" ]; then
    skip "there is no $corpus"
    finish test_corpus
    exit
fi
filters=$(verbs_of_kind filter)
check 'there are filters' test -n "$filters"
mkdir "$work/out"

# ---- Every good picture through every filter ---------------------------------------------------------------------

# The reference may not repair in another way either: both have the same to say.
for file in "$corpus"/photo/*.exr "$corpus"/render/*.exr "$corpus"/windows/*.exr "$corpus"/torture/*.exr; do
    name=${file#"$corpus"/}
    for verb in $filters; do
        expect_status 0 "$verb of $name" "$hdr" "$verb" : png -o "$work/fast.png" "$file"
        cp "$work/stderr" "$work/fast_stderr"
        # what keeps a tolerance only is compared where the exact sum does not take minutes: tests/oracle/test_durand.c
        if "$hdr" help --options "$verb" | grep -q '^--tolerance'; then continue; fi
        expect_status 0 "$verb --reference of $name" "$hdr" "$verb" --reference : png -o "$work/slow.png" "$file"
        check "$verb of $name: --reference gives the same bytes" cmp -s "$work/fast.png" "$work/slow.png"
        check "$verb of $name: --reference says the same" cmp -s "$work/fast_stderr" "$work/stderr"
        rm -f "$work/fast.png" "$work/slow.png"
    done
    expect_status 0 "facts of $name" "$hdr" stats --json "$file"
done

# ---- What is no number -------------------------------------------------------------------------------------------

# AllHalfValues holds each of the 65536 halves once in R, G and B: 3 x 2046 NaN (an exponent of all ones, a mantissa of
# 1 to 1023, either sign), 3 x 1 of each infinity. BrightRingsNanInf: counted by a program of OpenEXRCore's own reading
# routines alone.
non_finite() {
    expect_status 0 "$1" "$hdr" exr -o "$work/repaired.exr" "$corpus/torture/$1"
    check "$1: one line" stderr_lines 1
    check "$1: $2 NaN" stderr_has " $2 NaN"
    check "$1: $3 -Inf" stderr_has " $3 -Inf"
    check "$1: $4 +Inf" stderr_has " $4 +Inf"
    expect_status 65 "$1 --strict" "$hdr" exr --strict -o "$work/out/a.exr" "$corpus/torture/$1"
    check "$1 --strict: nothing is written" empty_directory "$work/out"
    expect_status 0 "$1, repaired" "$hdr" clamp : png -o "$work/a.png" "$work/repaired.exr"
    check "$1, repaired: nothing to repair" stderr_lines 0
}
non_finite AllHalfValues.exr 6138 3 3
non_finite BrightRingsNanInf.exr 6 6 6

# Words of a PFM whose exponent is all ones are NaN or infinite.
words_not_finite() {
    tail -c +"$(($(head -n 3 "$1" | wc -c) + 1))" "$1" | od -An -v -tx4 -w4 --endian=little | grep -cE '^ *[7f]f[89a-f]'
}
printf 'Pf\n4 1\n-1.0\n\001\002\200\177\377\377\377\377\000\000\200\377\377\377\177\177' >"$work/known.pfm"
check 'the test itself finds NaN and infinity' test "$(words_not_finite "$work/known.pfm")" -eq 3
for file in AllHalfValues BrightRingsNanInf WideFloatRange; do
    for verb in $filters; do
        expect_status 0 "$verb of $file to PFM" "$hdr" "$verb" -q : pfm -o "$work/a.pfm" "$corpus/torture/$file.exr"
        check "$verb of $file: everything is a number" test "$(words_not_finite "$work/a.pfm")" -eq 0
    done
done

# ---- Other ways to store a picture -------------------------------------------------------------------------------

for name in Adjuster Bonita Cannon Garden XYZ beachball_layers beachball_multipart dwa_night; do
    expect_status 0 "$name" "$hdr" log : png -o "$work/a.png" "$corpus/storage/$name.exr"
done
for name in sample.hdr test.pfm; do
    expect_status 0 "$name" "$hdr" log : png -o "$work/a.png" "$corpus/storage/$name"
done
# Luminance-chroma: blocks need the rows around them. (tests/oracle/test_yc.cc compares the pixels with the library's.)
for name in Flowers Rec709_YC XYZ_YC; do
    file=$corpus/storage/$name.exr
    expect_status 0 "$name" "$hdr" log -j 1 : png -o "$work/a.png" "$file"
    check "$name: nothing to say" stderr_lines 0
    for threads in 2 3 16; do
        expect_status 0 "$name -j $threads" "$hdr" log -j "$threads" : png -o "$work/b.png" "$file"
        check "$name: -j $threads gives the same bytes" cmp -s "$work/a.png" "$work/b.png"
    done
    for option in --reference --no-skip '--memory 3M'; do
        # shellcheck disable=SC2086 # an option and its value
        expect_status 0 "$name $option" "$hdr" log $option : png -o "$work/b.png" "$file"
        check "$name: $option gives the same bytes" cmp -s "$work/a.png" "$work/b.png"
    done
    "$hdr" log <"$file" | "$hdr" png >"$work/b.png"
    check "$name: a pipe gives the same bytes" cmp -s "$work/a.png" "$work/b.png"
    timeout 10 cat "$file" | "$hdr" log : png >"$work/b.png"
    check "$name: from a pipe the same bytes" cmp -s "$work/a.png" "$work/b.png"
done
# not_read FILE WORD: refused with a sentence that says what it is
not_read() {
    expect_status 65 "$1" "$hdr" png -o "$work/out/a.png" "$corpus/storage/$1"
    check "$1: one line that names the file" one_line_with "$1"
    check "$1: says that it is $2" stderr_has "$2"
    check "$1: nothing is written" empty_directory "$work/out"
}
not_read deep_trunks.exr 'deep data'

# ---- Damaged files -----------------------------------------------------------------------------------------------

compile_measure

damaged_file() { timeout 10 "$work/measure" "$work/used" "$hdr" "$1" -o "$work/out/a.png" "$2"; }
damaged_pipe() { timeout 10 cat "$2" | timeout 10 "$work/measure" "$work/used" "$hdr" "$1" -o "$work/out/a.png"; }

# refused HOW VERB FILE: 65, one line, nothing written, in less than 2 s and 256 MB
refused() {
    how="$1 $2 of ${3##*/}"
    rm -f "$work/used"
    expect_status 65 "$how" "$@"
    check "$how: one line" stderr_lines 1
    check "$how: which is printable" test -z "$(tr -d '[:print:]\n' <"$work/stderr")"
    check "$how: nothing is written" empty_directory "$work/out"
    check "$how: nothing is printed" test ! -s "$work/stdout"
    read -r kilobytes milliseconds <"$work/used"
    check "$how: $kilobytes KB" test "$kilobytes" -lt 262144
    check "$how: $milliseconds ms" test "$milliseconds" -lt 2000
}
damaged=0
for file in "$corpus"/broken/*; do
    damaged=$((damaged + 1))
    refused damaged_file png "$file"
    refused damaged_pipe log "$file"
done
check 'all damaged files are there' test "$damaged" -ge 90

finish test_corpus

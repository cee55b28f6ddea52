#!/bin/sh
# Facts of a whole shot: what stats tells of several files together, and --facts, which keeps a sequence from flickering
# while each frame is made by itself.
. tests/cli/lib.sh

# ---- Three frames, each darker than the one before; the first pixel is the same in all ---------------------------

# pixels VALUE...: as little-endian floats
pixels() {
    for value in "$@"; do
        case $value in
        0) printf '\000\000\000\000' ;;
        0.0625) printf '\000\000\200\075' ;;
        0.25) printf '\000\000\200\076' ;;
        1) printf '\000\000\200\077' ;;
        4) printf '\000\000\200\100' ;;
        64) printf '\000\000\200\102' ;;
        -1) printf '\000\000\200\277' ;;
        *) fail "no such pixel: $value" ;;
        esac
    done
}

# frame FILE VALUES...: a grey PFM of one row
frame() {
    file=$1
    shift
    { printf 'Pf\n%d 1\n-1.0\n' $# && pixels "$@"; } >"$file"
}

frame "$work/1.pfm" 0.25 4 64 4 64 64 4 1
frame "$work/2.pfm" 0.25 1 4 4 0.25 1 0 1
frame "$work/3.pfm" 0.25 0.0625 0.25 0.0625 -1 0.25 0.0625 0.0625
{ printf 'Pf\n8 3\n-1.0\n' && tail -c 32 "$work/1.pfm" && tail -c 32 "$work/2.pfm" && tail -c 32 "$work/3.pfm"; } >"$work/all.pfm"
frame "$work/dark.pfm" 0 0 -1
frame "$work/darker.pfm" -1 -1 -1

# ---- stats -------------------------------------------------------------------------------------------------------

# member NAME FILE: its number in the last line
member() {
    tail -n 1 "$2" | grep -o "\"$1\": [^,}]*" | head -n 1 | sed 's/.*: //'
}

# nearly A B: as sums in another order agree
nearly() {
    awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && b != "" && (a - b) ^ 2 <= (1e-14 * b) ^ 2) }'
}

# shellcheck disable=SC2120 # options and more files may follow
shot() { "$hdr" stats --json "$work/1.pfm" "$work/2.pfm" "$work/3.pfm" "$@"; }
expect_status 0 'facts of three files' shot
cp "$work/stdout" "$work/shot.json"
check 'facts of three files: nothing to say' stderr_lines 0
check 'three lines and one more' test "$(wc -l <"$work/shot.json")" -eq 4
check 'three of them are of files' test "$(grep -c '^{"file": ' "$work/shot.json")" -eq 3
check 'the last is of all' test "$(grep -n '^{"files": 3, ' "$work/shot.json" | cut -d : -f 1)" -eq 4
"$hdr" stats --json "$work/all.pfm" >"$work/all.json"
check 'one file: one line' test "$(wc -l <"$work/all.json")" -eq 1
check '24 pixels' test "$(member pixels "$work/shot.json")" = 24
for name in pixels lit nan positive_infinity negative_infinity negative unlit_colour min_luminance max_luminance min_lit \
    0.1 1 5 25 50 75 95 99 99.9 grey opaque; do
    check "three frames have the $name of one picture that holds all" \
        test "$(member "$name" "$work/shot.json")" = "$(member "$name" "$work/all.json")"
done
check 'and its log-average' nearly "$(member log_average "$work/shot.json")" "$(member log_average "$work/all.json")"
# 22 lit pixels, powers of two: exponent 6 three times, 2 five times, 0 four times, -2 six times, -4 four times
check 'the log-average is that of the exponents' nearly "$(member log_average "$work/shot.json")" \
    "$(awk 'BEGIN { printf "%.17g", 2 ^ ((3 * 6 + 5 * 2 - 6 * 2 - 4 * 4) / 22) }')"
check 'the median is of rank 11: 1' test "$(member 50 "$work/shot.json")" = 1
expect_status 0 'in words' "$hdr" stats "$work/1.pfm" "$work/2.pfm"
check 'in words: two blocks and one more' test "$(grep -c '^  pixels  *[0-9]' "$work/stdout")" -eq 3
check 'in words: a title' test "$(grep -c '^2 files together$' "$work/stdout")" -eq 1
check 'in words: all pixels' test "$(sed -n '/^2 files together$/,$s/^  pixels  *//p' "$work/stdout")" = 16
for option in -j1 -j3 --memory=1M --reference; do
    expect_status 0 "$option" shot "$option"
    check "$option: the same" cmp -s "$work/stdout" "$work/shot.json"
done

# files of several formats, sizes and colours; a pipe among them, which can be read only once
several() { "$hdr" stats --json testdata/glossy.exr "$1" testdata/tiny/alpha.exr; }
# shellcheck disable=SC2002 # a pipe is what is tried
through_pipe() { cat "$work/2.pfm" | several -; }
expect_status 0 'a picture among files' several "$work/2.pfm"
tail -n 1 "$work/stdout" >"$work/wanted"
expect_status 0 'a pipe among files' through_pipe
check 'a pipe among files: the same facts of all' test "$(tail -n 1 "$work/stdout")" = "$(cat "$work/wanted")"
mkfifo "$work/fifo"
cat "$work/2.pfm" >"$work/fifo" &
expect_status 0 'a FIFO among files' several "$work/fifo"
wait $!
check 'a FIFO among files: the same facts of all' test "$(tail -n 1 "$work/stdout")" = "$(cat "$work/wanted")"
expect_status 0 'bad pixels in two files' "$hdr" stats testdata/tiny/specials.exr "$work/1.pfm" testdata/tiny/specials.exr
check 'bad pixels are said once a file' stderr_lines 2
expect_status 0 'behind verbs' "$hdr" expose --ev 2 : stats --json "$work/1.pfm" "$work/2.pfm" "$work/3.pfm"
check 'behind verbs: four times as light' test "$(member max_luminance "$work/stdout")" = 256

# one that fails: no facts of all, since they would be wrong
expect_status 1 'a file is missing' shot "$work/missing.pfm"
check 'a file is missing: no facts of all' test "$(grep -c '"files"' "$work/stdout")" -eq 0
check 'a file is missing: the others are told' test "$(wc -l <"$work/stdout")" -eq 3
check 'a file is missing: it is said' stderr_has 'missing.pfm'
check 'a file is missing: and that there are no facts of all' stderr_has 'no facts of all files together: 1 of 4 failed'
expect_status 1 'a bad pixel and --strict' "$hdr" stats --strict "$work/1.pfm" testdata/tiny/specials.exr
check 'a bad pixel and --strict: no facts of all' test "$(grep -c together "$work/stdout")" -eq 0

# ---- --facts: no flicker -----------------------------------------------------------------------------------------

# codes FILE VERB OPTION...: of its pixels, in 8 bits
codes() {
    codes_of=$1
    shift
    "$hdr" "$@" : srgb : quantise : pfm -q -o "$work/codes.pfm" "$work/$codes_of.pfm" || return
    tail -n +4 "$work/codes.pfm" | od -An -v -tf4 -w4 | awk '{ printf "%.0f ", $1 * 255 }'
}
first_code() { codes "$@" | cut -d ' ' -f 1; }

for verb in exp log 'log --k 2' 'expose --auto' 'exp --per-channel' 'log --saturation 0.5'; do
    # shellcheck disable=SC2086 # words
    set -- $verb
    one=$(first_code 1 "$@") two=$(first_code 2 "$@") three=$(first_code 3 "$@")
    check "$verb: the frames flicker by themselves ($one $two $three)" test "$one" != "$two" -a "$two" != "$three"
    whole=$(codes all "$@")
    set -- "$@" --facts "$work/shot.json"
    one=$(first_code 1 "$@") two=$(first_code 2 "$@") three=$(first_code 3 "$@")
    check "$verb: with --facts a pixel has a code" test -n "$one" -a "$one" != 0 -a "$one" != 255
    check "$verb: with --facts it is the same in all ($one $two $three)" test "$one" = "$two" -a "$two" = "$three"
    frames=$(codes 1 "$@")$(codes 2 "$@")$(codes 3 "$@")
    check "$verb: with --facts all codes are those of one picture that holds all" test "$frames" = "$whole"
done
frames=$(codes 1 exp --facts "$work/all.json")
check 'facts of one file' test "$frames" = "$(codes 1 exp --facts "$work/shot.json")"
tail -n 1 "$work/shot.json" >"$work/last.json"
check 'the last line alone' test "$frames" = "$(codes 1 exp --facts "$work/last.json")"
check 'with =' test "$frames" = "$(codes 1 exp --facts="$work/shot.json")"
# shellcheck disable=SC2002 # a pipe is what is tried
from_pipe() { cat "$work/shot.json" | "$hdr" exp --facts /dev/stdin : pfm -o "$work/piped.pfm" "$work/1.pfm"; }
expect_status 0 'facts from a pipe' from_pipe
"$hdr" exp --facts "$work/shot.json" : pfm -o "$work/direct.pfm" "$work/1.pfm"
check 'facts from a pipe: the same' cmp -s "$work/piped.pfm" "$work/direct.pfm"

# no sweep is made for what is known
expect_status 0 'the plan' "$hdr" exp --facts "$work/shot.json" : png --explain -o "$work/a.png" "$work/1.pfm"
check 'the plan has no sweep for facts' test "$(grep -c '^sweep .*facts' "$work/stderr")" -eq 0
check 'the plan has one sweep' test "$(grep -c '^sweep ' "$work/stderr")" -eq 1
expect_status 0 'the plan without' "$hdr" exp : png --explain -o "$work/a.png" "$work/1.pfm"
check 'the plan without has one' test "$(grep -c '^sweep .*facts' "$work/stderr")" -eq 1

# nothing lit in the whole shot
for dark in dark darker; do
    "$hdr" stats --json "$work/dark.pfm" "$work/$dark.pfm" >"$work/dark.json"
    check "$dark: nothing is lit" test "$(member lit "$work/dark.json")" = 0
    check "$dark: log makes it black" test "$(codes 1 log --facts "$work/dark.json")" = '0 0 0 0 0 0 0 0 '
    check "$dark: exp makes it black" test "$(codes 1 exp --facts "$work/dark.json")" = '0 0 0 0 0 0 0 0 '
    check "$dark: expose leaves it" test "$(codes 1 expose --auto --facts "$work/dark.json")" = "$(codes 1 expose)"
done
"$hdr" stats --json "$work/darker.pfm" >"$work/dark.json"
check 'a maximum below 0' test "$(member max_luminance "$work/dark.json")" = -1
expect_status 0 'a maximum below 0 is taken' "$hdr" log --facts "$work/dark.json" : png -o "$work/a.png" "$work/1.pfm"

# ---- In a pipe, and on record ------------------------------------------------------------------------------------

for verb in exp log 'expose --auto'; do
    # shellcheck disable=SC2086
    "$hdr" $verb --facts "$work/shot.json" "$work/1.pfm" | cat >"$work/headed"
    line=$(sed -n '/^then /{p;q;}' "$work/headed")
    check "$verb: the head has numbers, and no name: $line" \
        test "$(printf '%s\n' "$line" | grep -cE "^then $verb --facts log_average=[0-9.e+-]+,max_luminance=64,p1=0\.0625,p99=64\$")" -eq 1
    # shellcheck disable=SC2086
    "$hdr" $verb --facts "$work/shot.json" : png -o "$work/direct.png" "$work/1.pfm"
    mv "$work/shot.json" "$work/away.json"
    "$hdr" png "$work/headed" >"$work/piped.png"
    check "$verb: a pipe gives the same bytes, without the file" cmp -s "$work/piped.png" "$work/direct.png"
    # shellcheck disable=SC2086
    expect_status 0 "$verb: the numbers as they stand" "$hdr" ${line#then } : png -o "$work/typed.png" "$work/1.pfm"
    check "$verb: the numbers as they stand: the same bytes" cmp -s "$work/typed.png" "$work/direct.png"
    mv "$work/away.json" "$work/shot.json"
done
three_programs() { "$hdr" expose --auto --facts "$work/shot.json" "$work/2.pfm" | "$hdr" log | "$hdr" png; }
expect_status 0 'three programs' three_programs
"$hdr" expose --auto --facts "$work/shot.json" : log : png -o "$work/direct.png" "$work/2.pfm"
check 'three programs: the same bytes' cmp -s "$work/stdout" "$work/direct.png"
expect_status 0 'on record' "$hdr" exp --facts "$work/shot.json" : exr --record -o "$work/recorded.exr" "$work/1.pfm"
check 'the record has numbers' grep -qa 'exp --facts log_average=[0-9.e+-]*,max_luminance=64,p1=0.0625,p99=64' "$work/recorded.exr"
check 'the record has no name' test "$(grep -ca 'shot.json' "$work/recorded.exr")" -eq 0

# a head names no file, whoever wrote it
head_with() { printf 'hdrpipe 1\nthen exp --facts %s\n\n' "$1" | cat - "$work/1.pfm" >"$work/headed"; }
for facts in "$work/shot.json" shot.json - log_average=1 log_average=nan,max_luminance=2,p1=1,p99=2 \
    log_average=1,max_luminance=2,p1=1,p99=4; do
    head_with "$facts"
    expect_status 65 "a head with $facts" "$hdr" png -o "$work/refused.png" "$work/headed"
    check "a head with $facts: the clause is named" stderr_has 'exp: --facts'
    check "a head with $facts: no picture" absent "$work/refused.png"
done
head_with log_average=1,max_luminance=2,p1=1,p99=2
expect_status 0 'a head with numbers' "$hdr" png -o "$work/a.png" "$work/headed"
printf 'hdrpipe 1\nthen exp --k 2 --facts log_average=1,max_luminance=2,p1=1,p99=2\n\n' | cat - "$work/1.pfm" >"$work/headed"
expect_status 65 'a head with facts that have no meaning' "$hdr" png -o "$work/refused.png" "$work/headed"

# ---- What is refused ---------------------------------------------------------------------------------------------

# refused STATUS WHAT FILE: as --facts; one sentence that names the file
refused() {
    expect_status "$1" "$2" "$hdr" exp --facts "$3" : png -o "$work/refused.png" "$work/1.pfm"
    check "$2: one line that names the file" one_line_with "$3"
    check "$2: it says which option" stderr_has 'hdr: exp: --facts: '
    check "$2: no picture" absent "$work/refused.png"
}

refused 66 'no file' "$work/missing.json"
refused 66 'a directory' "$work"
: >"$work/empty.json"
refused 65 'an empty file' "$work/empty.json"
check 'an empty file: what to do' stderr_has "make it with 'hdr stats --json'"
refused 65 'a picture' testdata/glossy.exr
refused 65 'a PFM' "$work/1.pfm"
head -c 100000 /dev/zero >"$work/zeros.json"
refused 65 'zeros' "$work/zeros.json"
head -n 3 "$work/shot.json" >"$work/no_total.json"
refused 65 'files without facts of all' "$work/no_total.json"
check 'files without facts of all: what to do' stderr_has 'of all frames at once'
cat "$work/shot.json" "$work/shot.json" >"$work/twice.json"
refused 65 'two shots' "$work/twice.json"
cat "$work/all.json" "$work/all.json" >"$work/two.json"
refused 65 'two files one by one' "$work/two.json"
sed 2d "$work/shot.json" >"$work/fewer.json"
refused 65 'a line is missing' "$work/fewer.json"
head -c 1500 "$work/shot.json" >"$work/short.json"
refused 65 'a file that is cut off' "$work/short.json"
"$hdr" info --json "$work/1.pfm" >"$work/info.json"
refused 65 'what info prints' "$work/info.json"
"$hdr" stats "$work/1.pfm" >"$work/words.txt"
refused 65 'stats without --json' "$work/words.txt"
sed 's/"log_average": /&-/' "$work/all.json" >"$work/negative.json"
refused 65 'a negative log-average' "$work/negative.json"
sed 's/"99": [^,]*/"99": 1e999/' "$work/all.json" >"$work/infinite.json"
refused 65 'an infinite percentile' "$work/infinite.json"
sed 's/"max_luminance": [^,]*/"max_luminance": 3/' "$work/all.json" >"$work/contradicting.json"
refused 65 'a maximum below a percentile' "$work/contradicting.json"
endless() { yes '{' | "$hdr" exp --facts /dev/stdin : png -o "$work/refused.png" "$work/1.pfm"; }
expect_status 65 'a pipe without end' endless

# misused WORDS...: a command that makes no sense
misused() {
    expect_status 64 "$*" "$hdr" "$@" : png -o "$work/refused.png" "$work/1.pfm"
    check "$*: it is said of --facts" stderr_has --facts
    check "$*: no picture" absent "$work/refused.png"
}
facts=$work/shot.json
misused exp --facts -
misused exp --facts ''
misused exp --facts log_average=1
misused exp --facts "$facts" --facts "$facts"
misused exp --facts "$facts" --k 2
misused exp --per-channel --facts "$facts" --k 2
misused expose --facts "$facts"
misused expose --ev 1 --facts "$facts"
misused log --mode range --facts "$facts"
misused log --mode literal --facts "$facts"
expect_status 64 'a verb that takes no facts' "$hdr" gamma --facts "$facts" : png -o "$work/refused.png" "$work/1.pfm"
check 'a verb that takes no facts: the option is named' one_line_with --facts

finish test_shot

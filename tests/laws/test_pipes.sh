#!/bin/sh
# Law 1: a pipe of programs writes the same bytes as one program with `then`, for every pair and triple of filters that the registry
# has; and what stands in the pipe meanwhile is a head and the picture file, byte for byte. Run from the project's root.
# shellcheck shell=sh
# shellcheck disable=SC1010 # `then` is a word of hdr's here
set -u
. tests/cli/lib.sh

tiny=testdata/tiny
render=testdata/glossy.exr
comment='# not pixels yet: end the pipe with hdr-png, hdr-exr, ..., or set HDR_DEFER=0'
filters=$(verbs_of_kind filter)

# same NAME A B: two files hold the same bytes.
same() {
    if cmp -s "$2" "$3"; then ok; else fail "$1: $2 and $3 differ"; fi
}

quiet_stderr() {
    if [ -s "$work/stderr" ]; then fail "$1: $(head -n 2 "$work/stderr")"; else ok; fi
}

# ---- Pipe = then ----

# outcome NAME STATUS FILE STATUS FILE: both the same pixels, or both refused.
outcome() {
    if [ "$2" -ne "$4" ]; then
        fail "$1: status $2 and $4"
    elif [ "$2" -eq 0 ]; then
        same "$1" "$3" "$5"
    elif [ "$2" -eq 65 ]; then
        ok # encoded twice
    else
        fail "$1: status $2"
    fi
}

check "there are filters" test -n "$filters"
for a in $filters; do
    picture=$tiny/primaries.exr
    for b in $filters; do
        "$hdr" "$a" "$picture" 2>/dev/null | "$hdr" "$b" >"$work/x.png" 2>/dev/null
        piped=$?
        "$hdr" "$a" then "$b" then png -o "$work/y.png" "$picture" 2>/dev/null
        outcome "$a | $b" $piped "$work/x.png" $? "$work/y.png"
        for c in $filters; do
            "$hdr" "$a" "$picture" 2>/dev/null | "$hdr" "$b" 2>/dev/null | "$hdr" "$c" >"$work/x.png" 2>/dev/null
            piped=$?
            "$hdr" "$a" : "$b" : "$c" then png -o "$work/y.png" "$picture" 2>/dev/null
            outcome "$a | $b | $c" $piped "$work/x.png" $? "$work/y.png"
        done
    done
done

# every picture, every way in; what cannot travel sends EXR, so it is the same as by way of a file
ways() {
    if [ "$("$hdr" "$1" "$2" 2>/dev/null | head -c 7 | tr -d '\0')" = hdrpipe ]; then
        "$hdr" "$1" then png -o "$work/y.png" "$2" 2>/dev/null
    else
        "$hdr" "$1" -o "$work/y.exr" "$2" 2>/dev/null
        "$hdr" png -o "$work/y.png" "$work/y.exr" 2>/dev/null
    fi
    "$hdr" "$1" <"$2" 2>/dev/null | "$hdr" png >"$work/x.png" 2>/dev/null
    same "$1 < $2" "$work/x.png" "$work/y.png"
    # shellcheck disable=SC2002 # a pipe is what is tried
    cat "$2" | "$hdr" "$1" 2>/dev/null | "$hdr" png -o "$work/x.png" - 2>/dev/null
    same "cat $2 | $1" "$work/x.png" "$work/y.png"
    "$hdr" "$1" - <"$2" 2>/dev/null | cat | "$hdr" png -o - 2>/dev/null | cat >"$work/x.png"
    same "$1 - < $2 | cat" "$work/x.png" "$work/y.png"
    "$work/bin/hdr-$1" "$2" 2>/dev/null | "$work/bin/hdr-png" -j 1 >"$work/x.png" 2>/dev/null
    same "hdr-$1 $2" "$work/x.png" "$work/y.png"
    HDR_THREADS=2 "$hdr" "$1" "$2" 2>/dev/null | HDR_THREADS=1 "$hdr" png >"$work/x.png" 2>/dev/null
    same "$1 $2 with other threads" "$work/x.png" "$work/y.png"
    "$hdr" "$1" then png -o "$work/y.png" "$2" 2>/dev/null
    "$work/bin/hdr-$1" : png -j 2 "$2" >"$work/x.png" 2>/dev/null
    same "hdr-$1 : png" "$work/x.png" "$work/y.png"
}

mkdir "$work/bin"
for verb in $("$hdr" help --list | cut -f 1); do ln -s "$hdr" "$work/bin/hdr-$verb"; done
for verb in $filters; do
    for picture in "$tiny"/*.exr; do ways "$verb" "$picture"; done
done
for verb in $filters; do ways "$verb" "$render"; done

# ---- The head ----

# head LINE...: writes a head of these lines, and the empty one, to $work/head.
head_of() {
    printf '%s\n' "$@" >"$work/head"
    echo >>"$work/head"
}

# what the pipe holds is exactly $work/head, then the file
pipe_holds() {
    cat "$work/head" "$2" >"$work/expected"
    same "$1" "$work/piped" "$work/expected"
}

"$hdr" log --mode range --percentile 0.5 "$render" | cat >"$work/piped"
head_of 'hdrpipe 1' "$comment" 'then log --mode range --percentile 0.5'
pipe_holds "one clause" "$render"

"$hdr" expose --ev=-1.5 --window=data <"$render" | "$hdr" exp -j2 -q | "$hdr" gamma -g1.8 --no-skip --memory 8M | cat >"$work/piped"
head_of 'hdrpipe 1' "$comment" 'read --window data --no-skip' 'then expose --ev -1.5' 'then exp' 'then gamma --exponent 1.8'
pipe_holds "three programs" "$render"

"$hdr" expose --ev +0.5 then log --per-channel then gamma -g 2.2 "$tiny/ramp.exr" | cat >"$work/piped"
head_of 'hdrpipe 1' "$comment" 'then expose --ev +0.5' 'then log --per-channel' 'then gamma --exponent 2.2'
pipe_holds "one program with three clauses" "$tiny/ramp.exr"

# what travels, and what stays
for option in --reference --strict --no-skip "--window data" "--primaries keep" "--adapt none" "--alpha drop" \
    "--alpha over:0,0.5,+1e-2"; do
    # shellcheck disable=SC2086 # two words
    "$hdr" exp $option "$tiny/ramp.exr" | "$hdr" gamma | cat >"$work/piped"
    head_of 'hdrpipe 1' "$comment" "read $option" 'then exp' 'then gamma'
    pipe_holds "$option travels" "$tiny/ramp.exr"
    # shellcheck disable=SC2086
    "$hdr" exp "$tiny/ramp.exr" | "$hdr" gamma $option | cat >"$work/piped"
    pipe_holds "$option of the second program" "$tiny/ramp.exr"
    # shellcheck disable=SC2086
    "$hdr" exp $option "$tiny/ramp.exr" | "$hdr" gamma $option | cat >"$work/piped"
    pipe_holds "$option twice" "$tiny/ramp.exr"
done
for option in "-j 2" -q -v --explain "--memory 64M"; do
    # shellcheck disable=SC2086
    "$hdr" exp $option "$tiny/ramp.exr" 2>/dev/null | cat >"$work/piped"
    head_of 'hdrpipe 1' "$comment" 'then exp'
    pipe_holds "$option stays" "$tiny/ramp.exr"
done

# and it is obeyed at the other end
"$hdr" exp --window data "$tiny/window.exr" | "$hdr" png >"$work/x.png"
"$hdr" exp then png --window data -o "$work/y.png" "$tiny/window.exr"
"$hdr" exp then png -o "$work/z.png" "$tiny/window.exr"
same "--window data in a pipe" "$work/x.png" "$work/y.png"
if cmp -s "$work/y.png" "$work/z.png"; then fail "--window data makes no difference"; else ok; fi
"$hdr" exp --strict "$tiny/specials.exr" | "$hdr" png >"$work/x.png" 2>"$work/stderr"
check "--strict in a pipe" test $? -eq 65
check "--strict says so once" stderr_lines 1
"$hdr" expose --no-skip "$tiny/ramp.exr" | "$hdr" png --explain 2>"$work/stderr" >"$work/x.png"
if stderr_has '(expose) skipped'; then fail "--no-skip in a pipe"; else ok; fi
"$hdr" expose "$tiny/ramp.exr" | "$hdr" png --explain 2>"$work/stderr" >"$work/y.png"
check "a skip in a pipe" stderr_has '(expose) skipped'
same "--no-skip and skipped" "$work/x.png" "$work/y.png"
foreign=${HDRPIPE_CORPUS:-../shared/corpus}/storage/XYZ.exr
if [ -r "$foreign" ]; then
    for option in "--primaries keep" "--adapt none" "--alpha drop" \
    "--alpha over:0,0.5,+1e-2"; do
        # shellcheck disable=SC2086
        "$hdr" exp $option "$foreign" | "$hdr" png >"$work/x.png"
        # shellcheck disable=SC2086
        "$hdr" exp then png $option -o "$work/y.png" "$foreign"
        same "$option in a pipe" "$work/x.png" "$work/y.png"
    done
else
    skip "no $foreign: primaries of a file"
fi

# in front of a file on disk
"$hdr" log "$render" | cat >"$work/headed"
"$hdr" log then exp then png -o "$work/y.png" "$render"
"$hdr" exp "$work/headed" >"$work/x.png"
same "head on disk" "$work/x.png" "$work/y.png"
"$hdr" exp <"$work/headed" >"$work/x.png"
same "head on disk, standard input" "$work/x.png" "$work/y.png"
"$hdr" exp "$work/headed" | "$hdr" png >"$work/x.png"
same "head on disk, handed on" "$work/x.png" "$work/y.png"
"$hdr" log then stats "$render" | sed "s,$render,,g" >"$work/y.txt"
"$hdr" stats "$work/headed" | sed "s,$work/headed,,g" >"$work/x.txt"
same "stats behind a head" "$work/x.txt" "$work/y.txt"

# ---- Heads that are read ----

# reads NAME LINE...: a head of these lines makes what log then gamma -g 1.8 makes.
reads() {
    reads_name=$1
    shift
    head_of "$@"
    cat "$work/head" "$tiny/ramp.exr" >"$work/headed"
    "$hdr" png "$work/headed" >"$work/x.png" 2>"$work/stderr"
    quiet_stderr "$reads_name"
    same "$reads_name" "$work/x.png" "$work/y.png"
}

"$hdr" log then gamma -g 1.8 then png -o "$work/y.png" "$tiny/ramp.exr"
reads "plain" 'hdrpipe 1' 'then log' 'then gamma --exponent 1.8'
reads "=" 'hdrpipe 1' 'then log' 'then gamma --exponent=1.8'
reads "escapes" 'hdrpipe 1' 'then l%6Fg' 'then gamma --exponent %31%2E8'
reads "comments" 'hdrpipe 1' '# any  byte: "!%&' 'then log' '#' 'then gamma --exponent 1.8' '# end'
reads "read line" 'hdrpipe 1' 'read --no-skip --window display' 'then log' 'then gamma --exponent 1.8'
"$hdr" png -o "$work/y.png" "$tiny/ramp.exr"
reads "no clause" 'hdrpipe 1'
reads "comment only" 'hdrpipe 1' '# nothing'
# the largest: 64 KiB with the empty line
padding() { # its line's length is chosen so that the head has $1 bytes
    printf '#%*s' $(($1 - 10 - 1 - 2)) ''
}
reads "64 KiB" 'hdrpipe 1' "$(padding 65536)"
check "that was 64 KiB" test "$(wc -c <"$work/head")" -eq 65536

# ---- Heads that are refused: 65, one line (and the option's own help line), no output ----

one_fault() {
    head -n 1 "$work/stderr" | grep -q '^hdr: .' && ! tail -n +2 "$work/stderr" | grep -qv '^  .*--' &&
        [ "$(wc -l <"$work/stderr")" -le 2 ]
}

# refused NAME: what is in $work/headed.
refused() {
    rm -f "$work/out.png"
    expect_status 65 "$1" "$hdr" png -o "$work/out.png" "$work/headed"
    check "$1: one line, not $(wc -l <"$work/stderr")" one_fault
    check "$1: no output" absent "$work/out.png"
}

# refuse NAME LINE...
refuse() {
    refuse_name=$1
    shift
    head_of "$@"
    cat "$work/head" "$tiny/ramp.exr" >"$work/headed"
    refused "$refuse_name"
}

refuse "version" 'hdrpipe 2' 'then log'
check "version: said to be newer" stderr_has newer
refuse "version 10" 'hdrpipe 10' 'then log'
refuse "version with a space" 'hdrpipe 1 ' 'then log'
refuse "carriage return" "$(printf 'hdrpipe 1\r')" 'then log'
refuse "no version" 'hdrpipe ' 'then log'
refuse "unknown verb" 'hdrpipe 1' 'then nonesuch'
check "unknown verb: said to be newer" stderr_has newer
refuse "unknown option" 'hdrpipe 1' 'then log --nonesuch 3'
refuse "value out of range" 'hdrpipe 1' 'then gamma --exponent -1'
refuse "value missing" 'hdrpipe 1' 'then gamma --exponent'
refuse "no number" 'hdrpipe 1' 'then gamma --exponent inf'
refuse "option twice" 'hdrpipe 1' 'then gamma --exponent 2 --exponent 2'
refuse "options that exclude each other" 'hdrpipe 1' 'then log --mode range --k 2'
refuse "letter" 'hdrpipe 1' 'then gamma -g 2'
refuse "operand" 'hdrpipe 1' 'then log file.exr'
refuse "dashes" 'hdrpipe 1' 'then log -- file.exr'
refuse "format" 'hdrpipe 1' 'then png'
refuse "program" 'hdrpipe 1' 'then stats'
refuse "output" 'hdrpipe 1' "then log --output $work/stolen.png"
refuse "output in the read line" 'hdrpipe 1' "read --output $work/stolen.png" 'then log'
check "no stolen output" absent "$work/stolen.png"
refuse "threads in the read line" 'hdrpipe 1' 'read --threads 2' 'then log'
refuse "memory in the read line" 'hdrpipe 1' 'read --memory 8M' 'then log'
refuse "unknown reading option" 'hdrpipe 1' 'read --nonesuch' 'then log'
refuse "read behind then" 'hdrpipe 1' 'then log' 'read --no-skip'
refuse "two read lines" 'hdrpipe 1' 'read --no-skip' 'read --strict' 'then log'
refuse "reading option of a clause" 'hdrpipe 1' 'then log --window data'
refuse "double space" 'hdrpipe 1' 'then  log'
refuse "double space before an option" 'hdrpipe 1' 'then gamma  --exponent 2'
refuse "space at the end" 'hdrpipe 1' 'then log '
refuse "space in front" 'hdrpipe 1' ' then log'
refuse "tab" 'hdrpipe 1' "$(printf 'then\tlog')"
refuse "unescaped byte" 'hdrpipe 1' 'then gamma --exponent 2!'
refuse "unescaped umlaut" 'hdrpipe 1' "$(printf 'then gamma --exponent \303\244')"
refuse "escape cut short" 'hdrpipe 1' 'then gamma --exponent 2%3'
refuse "escape of no digits" 'hdrpipe 1' 'then gamma --exponent 2%ZZ'
refuse "escaped NUL" 'hdrpipe 1' 'then gamma --exponent 2%00'
refuse "escaped space" 'hdrpipe 1' 'then gamma%20--exponent 2'
refuse "other word" 'hdrpipe 1' 'and log'
refuse "then without a verb" 'hdrpipe 1' 'then'
refuse "colon" 'hdrpipe 1' ': log'
refuse "a head in a head" 'hdrpipe 1' 'then log' '' 'hdrpipe 1' 'then exp'
refuse "more than 64 KiB" 'hdrpipe 1' "$(padding 65537)"

printf 'hdrpipe 1\nthen log\n' >"$work/headed"
refused "no empty line at the end of the file"
{ printf 'hdrpipe 1\nthen log\n' && cat "$tiny/ramp.exr"; } >"$work/headed"
refused "no empty line in front of the picture"
printf 'hdrpipe 1\nthen log\n\n' >"$work/headed"
refused "no picture"
{ printf 'hdrpipe 1\n# \000\nthen log\n\n' && cat "$tiny/ramp.exr"; } >"$work/headed"
refused "NUL in a comment"
{ printf 'hdrpipe 1\nthen log\000\n\n' && cat "$tiny/ramp.exr"; } >"$work/headed"
refused "NUL in a clause"
printf 'hdrpipe' >"$work/headed"
refused "half a first line"
# a filter that only hands on does not hand on what it cannot read
{ printf 'hdrpipe 1\nthen nonesuch\n\n' && cat "$tiny/ramp.exr"; } >"$work/headed"
{ "$hdr" exp "$work/headed" 2>"$work/stderr"; echo $? >"$work/status"; } | cat >"$work/piped"
check "handing on an unknown verb" test "$(cat "$work/status")" -eq 65
check "handing on an unknown verb: nothing" test ! -s "$work/piped"

# ---- Without deferring, and to other places ----

HDR_DEFER=0 "$hdr" log "$render" | cat >"$work/x.exr"
check "HDR_DEFER=0 gives an EXR" is_exr "$work/x.exr"
"$hdr" log then exr -o "$work/y.exr" "$render"
same "HDR_DEFER=0 and exr" "$work/x.exr" "$work/y.exr"
for a in $filters; do
    HDR_DEFER=0 "$hdr" "$a" "$tiny/primaries.exr" 2>/dev/null | HDR_DEFER=0 "$hdr" png 2>/dev/null | cat >"$work/x.png"
    check "HDR_DEFER=0 $a | png" is_png "$work/x.png"
done
# encoding twice by way of a file is refused, as it is without one
HDR_DEFER=0 "$hdr" srgb "$render" | "$hdr" gamma then png -o "$work/x.png" 2>/dev/null
check "encoded twice by way of an EXR" test $? -eq 65
# a picture of few values passes through float32 without a change
"$hdr" expose --ev 1 then png -o "$work/y.png" "$tiny/ramp.exr"
HDR_DEFER=0 "$hdr" expose --ev 1 "$tiny/ramp.exr" | "$hdr" png >"$work/x.png"
same "HDR_DEFER=0 of what float32 holds" "$work/x.png" "$work/y.png"

"$hdr" log "$render" >"$work/a.png"
check "> a.png" is_png "$work/a.png"
"$hdr" log then png -o "$work/y.png" "$render"
same "> a.png and png" "$work/a.png" "$work/y.png"
"$hdr" log "$render" >"$work/a.exr"
check "> a.exr" is_exr "$work/a.exr"
"$hdr" log "$render" >"$work/a"
check "> a" is_exr "$work/a"
"$hdr" log "$render" >"$work/a.pfm"
check "> a.pfm" test "$(head -c 2 "$work/a.pfm")" = PF
"$hdr" log -o - "$render" >"$work/b.png"
check "-o - > b.png" is_exr "$work/b.png"
"$hdr" log -o - "$render" | cat >"$work/b"
check "-o - | cat" is_exr "$work/b"
"$hdr" log then png -o - "$render" >"$work/b"
check "png -o - > b" is_png "$work/b"
"$hdr" log then png -o - "$render" | cat >"$work/b"
check "png -o - | cat" is_png "$work/b"
"$hdr" log -o "$work/c.png" "$render" | cat >"$work/nothing"
check "-o c.png in a pipe" is_png "$work/c.png"
check "-o c.png in a pipe: nothing in the pipe" test ! -s "$work/nothing"

# ---- A reader that goes away: SIGPIPE, without a word ----

# quietly_ended NAME: the status of the program is in $work/status.
quietly_ended() {
    quiet_stderr "$1 | head -c 1"
    check "$1 | head -c 1: status $(cat "$work/status")" test "$(cat "$work/status")" -eq 141
}

# more than a pipe can be made to hold; what stands behind a picture is handed on like the rest
{ cat "$render" && head -c 4000000 /dev/zero; } >"$work/long.exr"
{ "$hdr" log "$work/long.exr" 2>"$work/stderr"; echo $? >"$work/status"; } | head -c 1 >/dev/null
quietly_ended "deferred"
# shellcheck disable=SC2002
cat "$work/long.exr" 2>/dev/null | { "$hdr" log 2>"$work/stderr"; echo $? >"$work/status"; } | head -c 1 >/dev/null
quietly_ended "deferred from a pipe"
{ "$hdr" log then png --bits 16 "$render" 2>"$work/stderr"; echo $? >"$work/status"; } | head -c 1 >/dev/null
quietly_ended "png"
{ "$hdr" log then exr "$render" 2>"$work/stderr"; echo $? >"$work/status"; } | head -c 1 >/dev/null
quietly_ended "exr"

finish test_pipes

#!/bin/sh
# Exit statuses, the words that go with them, and that nothing is ever half-written under the output's name.
. tests/cli/lib.sh

picture=testdata/glossy.exr
specials=testdata/tiny/specials.exr
"$hdr" png -o "$work/good.png" "$picture" || fail 'a plain PNG'

# ---- Words that make no command ----------------------------------------------------------------------------------

# bad_option VERB OPTION COMMAND...: 64, and the second line is the one that --help shows for the option.
bad_option() {
    verb=$1 option=$2
    shift 2
    expect_status 64 "$*" "$@"
    "$hdr" "$verb" --help | grep -E "^ *(-., )?--$option( |\$)" >"$work/help_line"
    sed 1d "$work/stderr" >"$work/said_line"
    check "$*: the option's help line" cmp -s "$work/help_line" "$work/said_line"
    check "$*: names the verb" grep -q "^hdr: $verb: --$option" "$work/stderr"
}

bad_option gamma exponent "$hdr" gamma --exponent 0 "$picture"
bad_option gamma exponent "$hdr" gamma --exponent 1e7 "$picture"
bad_option gamma exponent "$hdr" gamma --exponent 1e999 "$picture"
bad_option gamma exponent "$hdr" gamma --exponent nan "$picture"
bad_option gamma exponent "$hdr" gamma --exponent inf "$picture"
bad_option gamma exponent "$hdr" gamma --exponent 0x2 "$picture"
bad_option gamma exponent "$hdr" gamma -g2,2 "$picture"
bad_option gamma exponent "$hdr" gamma '-g 2' "$picture"
bad_option gamma exponent "$hdr" gamma -g
bad_option gamma exponent "$hdr" gamma -g 2 --exponent=2 "$picture"
bad_option quantise bits "$hdr" quantise --bits 8.5 "$picture"
bad_option log mode "$hdr" log --mode Shifted "$picture"
bad_option png threads "$hdr" log -j 1 : png -j 1 "$picture"
bad_option divmax percentile "$hdr" divmax --percentile 100.0000001 "$picture"
bad_option divmax percentile "$hdr" divmax --percentile -1 "$picture"
bad_option png memory "$hdr" png --memory 3Q "$picture"
bad_option srgb decode "$hdr" srgb --decode=yes "$picture"

# every option of every verb: without its value, with a bad one, twice
for verb in $("$hdr" help --list | cut -f 1); do
    for option in $("$hdr" help --options "$verb" | sed 's/^--\([^ ]*\).*/\1/'); do
        line=$("$hdr" "$verb" --help | grep -E "^ *(-., )?--$option( |\$)")
        # only a value's name stands one space behind the option's
        if printf '%s\n' "$line" | grep -qE -- "--$option [^ ]"; then
            bad_option "$verb" "$option" "$hdr" "$verb" "--$option"
            case $verb-$option in
            *-output) ;;
            *-part | *-layer | *-channel | *-facts | *-against | *-sampling-map | *-deviation-map | *-flip-map | *-sigma-picture | ocio-*) bad_option "$verb" "$option" "$hdr" "$verb" "--$option=" ;; # any other name may be one
            *) bad_option "$verb" "$option" "$hdr" "$verb" "--$option=@@" ;;
            esac
        else
            bad_option "$verb" "$option" "$hdr" "$verb" "--$option" "--$option"
        fi
    done
    expect_status 64 "$verb: unknown option" "$hdr" "$verb" --no-such-option "$picture"
    check "$verb: unknown option is named" one_line_with --no-such-option
    expect_status 64 "$verb: unknown letter" "$hdr" "$verb" -Z "$picture"
done

expect_status 64 'no words at all' "$hdr"
expect_status 64 'unknown verb' "$hdr" lgo "$picture"
check 'unknown verb is named' one_line_with lgo
expect_status 64 'verb after a format' "$hdr" png 'then' srgb "$picture"
check 'verb after a format: one line' one_line_with png
expect_status 64 'nothing behind then' "$hdr" log 'then'
expect_status 64 'then at the beginning' "$hdr" 'then' log
expect_status 64 'two files for one picture' "$hdr" png "$picture" "$picture"
expect_status 64 '--min above --max' "$hdr" clamp --min 2 --max 1 "$picture"
expect_status 64 '--auto with --ev' "$hdr" expose --auto --ev 1 "$picture"
expect_status 64 'an option of another mode' "$hdr" log --mode range --k 2 "$picture"
expect_status 64 'an ending of no format' "$hdr" log -o "$work/a.xyz" "$picture"
check 'an ending of no format is named' one_line_with a.xyz
expect_status 64 '-o for a program that prints' "$hdr" info -o "$work/a" "$picture"
check 'nothing was written' absent "$work/a"
expect_status 0 '--help' "$hdr" gamma --help
check '--help is on standard output' grep -q -- --exponent "$work/stdout"
expect_status 0 '--version' "$hdr" --version
check '--version is on standard output' grep -q '^hdrpipe [0-9]' "$work/stdout"

# ---- Input that is not there, or no good -------------------------------------------------------------------------

mkdir "$work/out"

# refused STATUS NAME COMMAND...: the command, which is to write into $work/out, leaves nothing there.
refused() {
    expect_status "$@"
    check "$2: nothing is left in the output's directory" empty_directory "$work/out"
    rm -rf "$work/out"
    mkdir "$work/out"
}

refused 66 'missing file' "$hdr" png -o "$work/out/a.png" "$work/missing.exr"
check 'missing file is named, in one line' one_line_with "$work/missing.exr"
refused 66 'missing file, to standard output' "$hdr" png "$work/missing.exr"
refused 66 'a directory' "$hdr" png -o "$work/out/a.png" "$work"
check 'a directory is named, in one line' one_line_with "$work:"
refused 66 'a word instead of a file' "$hdr" png help

read_nothing() { "$hdr" png -o "$work/out/a.png" </dev/null; }
refused 65 'empty standard input' read_nothing
check 'empty standard input: one line' one_line_with 'standard input'
: >"$work/empty.exr"
refused 65 'empty file' "$hdr" png -o "$work/out/a.png" "$work/empty.exr"
printf 'no picture' >"$work/text.exr"
refused 65 'a text' "$hdr" png -o "$work/out/a.png" "$work/text.exr"

size=$(wc -c <"$picture")
cut_short() { head -c "$1" "$picture" | "$hdr" "$2" -o "$work/out/a.$2"; }
for length in 1 4 8 100 1000 5000 $((size / 2)) $((size - 1)); do
    head -c "$length" "$picture" >"$work/short.exr"
    refused 65 "a file of $length bytes" "$hdr" png -o "$work/out/a.png" "$work/short.exr"
    check "a file of $length bytes: one line" one_line_with "$work/short.exr"
    refused 65 "a pipe of $length bytes" cut_short "$length" png
    check "a pipe of $length bytes: one line" one_line_with 'standard input'
    refused 65 "a pipe of $length bytes, to EXR" cut_short "$length" exr
    refused 65 "statistics of $length bytes" "$hdr" stats "$work/short.exr"
    check "no statistics of $length bytes" test ! -s "$work/stdout"
done

# one file of several: the others are reported all the same
expect_status 1 'one missing file of three' "$hdr" info "$picture" "$work/missing.exr" "$picture"
check 'one missing file of three is named' one_line_with "$work/missing.exr"
check 'the two others are reported' test "$(grep -c '^testdata/glossy' "$work/stdout")" -eq 2

upstream_fails() { "$hdr" log "$1" | "$hdr" png -o "$work/out/a.png"; }
refused 65 'a pipe whose first program fails' upstream_fails "$work/missing.exr"
check 'the first program says why' stderr_has "$work/missing.exr"
refused 65 'a pipe whose first program gets half a file' upstream_fails "$work/short.exr"
three_programs() { "$hdr" log "$work/missing.exr" | "$hdr" srgb | "$hdr" png >"$work/stdin_to_file"; }
refused 65 'three programs, the first one fails' three_programs
check 'nothing was written by three programs' test ! -s "$work/stdin_to_file"

closed_input() { "$hdr" png -o "$work/out/a.png" <&-; }
refused 74 'standard input is closed' closed_input
check 'standard input is closed: one line, named once' one_line_with 'standard input'

# ---- Output that cannot be written -------------------------------------------------------------------------------

to_full() { "$hdr" "$@" "$picture" >/dev/full; }
by_name_to_full() { "$hdr" "$1" -o /dev/full "$picture"; }
if [ -c /dev/full ]; then
    for format in $(verbs_of_kind format); do
        expect_status 74 "$format to a full disk" to_full "$format"
        check "$format to a full disk: one line" one_line_with 'standard output'
        expect_status 74 "$format -o /dev/full" by_name_to_full "$format"
        check "$format -o /dev/full: one line" one_line_with /dev/full
    done
    expect_status 74 'a filter to a full disk' to_full log
    expect_status 74 'facts to a full disk' to_full stats --json
    expect_status 74 'help to a full disk' to_full log --help
else
    skip 'there is no /dev/full'
fi

# a file may grow to a limit only, as batch systems have it: no other fault than a full disk, and no end by SIGXFSZ
limited() (
    ulimit -f 8
    "$hdr" "$1" -o "$work/out/a.$1" "$picture"
)
refused 74 'a PNG that outgrows the limit' limited png
refused 74 'an EXR that outgrows the limit' limited exr
refused 74 'a PFM that outgrows the limit' limited pfm

expect_status 73 'output in a missing directory' "$hdr" png -o "$work/no/such/a.png" "$picture"
check 'output in a missing directory: one line' one_line_with "$work/no/such/a.png"
expect_status 73 'output is a directory' "$hdr" png -o "$work/out" "$picture"
check 'the directory is still there' test -d "$work/out"
expect_status 73 'output below a file' "$hdr" png -o "$work/good.png/a.png" "$picture"
expect_status 73 'output has no name' "$hdr" png -o '' "$picture"
ln -s loop.png "$work/loop.png"
expect_status 73 'output is a link to itself' "$hdr" png -o "$work/loop.png" "$picture"

# Root may write anywhere, so it becomes nobody for this, if nobody can read the program and the picture.
mkdir -m 555 "$work/locked"
chmod 755 "$work"
as_nobody() {
    if [ "$(id -u)" -ne 0 ]; then "$@"; else setpriv --reuid=65534 --regid=65534 --clear-groups "$@"; fi
}
if as_nobody "$hdr" info "$picture" >"$work/stdout" 2>&1; then
    expect_status 73 'unwritable directory' as_nobody "$hdr" png -o "$work/locked/a.png" "$picture"
    check 'unwritable directory: one line' one_line_with "$work/locked/a.png"
    mkdir -m 777 "$work/open"
    cp "$work/good.png" "$work/open/kept.png"
    chmod 444 "$work/open/kept.png"
    expect_status 73 'write-protected file' as_nobody "$hdr" png -o "$work/open/kept.png" "$specials"
    check 'write-protected file is kept' cmp -s "$work/good.png" "$work/open/kept.png"
else
    skip 'an unwritable directory: the user is root, and nobody else may run the program'
fi

closed_output() { "$hdr" "$@" "$picture" >&-; }
expect_status 73 'standard output is closed' closed_output png
check 'standard output is closed: one line' one_line_with 'standard output'
expect_status 74 'standard output is closed, info' closed_output info
all_closed() { "$hdr" png -o "$work/closed.png" "$picture" <&- >&- 2>&-; }
expect_status 0 'all standard descriptors are closed' all_closed
check 'the same picture with all descriptors closed' cmp -s "$work/good.png" "$work/closed.png"
notes_closed() { "$hdr" png -o "$work/closed.png" "$specials" <&- >&- 2>&-; }
expect_status 0 'all closed, and something to say' notes_closed
check 'words do not get into the picture' is_png "$work/closed.png"

# ---- Terminals ---------------------------------------------------------------------------------------------------

# on_terminal COMMAND: a line for the shell, with a terminal for all three standard descriptors
if script -qec true /dev/null </dev/null >/dev/null 2>&1; then
    on_terminal() { script -qec "$1" /dev/null </dev/null; }
elif python3 -c 'import pty' 2>/dev/null; then
    on_terminal() {
        python3 -c 'import os, pty, sys; sys.exit(os.waitstatus_to_exitcode(pty.spawn(["sh", "-c", sys.argv[1]])))' "$1" </dev/null
    }
else
    on_terminal() { return 127; }
fi
if on_terminal true >/dev/null; then
    expect_status 64 'standard input is a terminal' on_terminal "'$hdr' png -o '$work/out/a.png'"
    check 'standard input is a terminal: it is said' grep -q 'standard input is a terminal' "$work/stdout"
    check 'standard input is a terminal: nothing is left' empty_directory "$work/out"
    for verb in png exr log; do
        expect_status 64 "$verb to a terminal" on_terminal "'$hdr' $verb $picture"
        check "$verb to a terminal: it is said" grep -q 'standard output is a terminal' "$work/stdout"
        check "$verb to a terminal: nothing else is" test "$(wc -c <"$work/stdout")" -lt 200
    done
    expect_status 0 'facts to a terminal' on_terminal "'$hdr' info $picture"
    check 'facts to a terminal: no colours' test -z "$(tr -dc '\033' <"$work/stdout")"
else
    skip 'terminals: neither script nor python3 is there'
fi

# ---- Output under its name ---------------------------------------------------------------------------------------

cp "$work/good.png" "$work/out/kept.png"
expect_status 65 'a failing run onto an existing file' "$hdr" png -o "$work/out/kept.png" "$work/short.exr"
check 'the existing file is kept' cmp -s "$work/good.png" "$work/out/kept.png"
check 'nothing beside it' test "$(ls -A "$work/out")" = kept.png
chmod 604 "$work/out/kept.png"
expect_status 0 'a good run onto an existing file' "$hdr" png -o "$work/out/kept.png" testdata/object.exr
check 'it is replaced' test "$(cmp -s "$work/good.png" "$work/out/kept.png" || echo differs)" = differs
check 'it keeps its permissions' test "$(stat -c %a "$work/out/kept.png")" = 604

ln -s kept.png "$work/out/link.png"
ln -s new.png "$work/out/dangling.png"
for link in link.png:kept.png dangling.png:new.png; do
    expect_status 0 "onto the link ${link%:*}" "$hdr" png -o "$work/out/${link%:*}" "$picture"
    check "${link%:*} is still a link" test -L "$work/out/${link%:*}"
    check "${link%:*}: its target is written" cmp -s "$work/good.png" "$work/out/${link#*:}"
done

with_umask() (
    umask "$1"
    "$hdr" png -o "$work/out/mode$1.png" "$picture"
)
for mask in 027:640 022:644 077:600 000:666; do
    expect_status 0 "umask ${mask%:*}" with_umask "${mask%:*}"
    check "umask ${mask%:*}: permissions" test "$(stat -c %a "$work/out/mode${mask%:*}.png")" = "${mask#*:}"
done

mkfifo "$work/fifo"
cat "$work/fifo" >"$work/through_fifo.png" &
expect_status 0 'to a FIFO' "$hdr" png -o "$work/fifo" "$picture"
wait $!
check 'to a FIFO: the same bytes' cmp -s "$work/good.png" "$work/through_fifo.png"
check 'the FIFO is still one' test -p "$work/fifo"
expect_status 0 'to /dev/null' "$hdr" png -o /dev/null "$picture"
check '/dev/null is still a device' test -c /dev/null
expect_status 0 'to standard output by -' "$hdr" png -o - "$picture"
check 'to standard output by -: the same bytes' cmp -s "$work/good.png" "$work/stdout"
redirected() { "$hdr" srgb "$picture" >"$1"; }
expect_status 0 'a filter to a file called .png' redirected "$work/named.png"
check 'it is a PNG' is_png "$work/named.png"
expect_status 0 'a filter to a file without ending' redirected "$work/named"
check 'it is an EXR' is_exr "$work/named"
expect_status 0 'a filter, -o without ending' "$hdr" srgb -o "$work/plain" "$picture"
check 'it is the same EXR' cmp -s "$work/named" "$work/plain"
cp "$picture" "$work/itself.exr"
expect_status 0 'onto the input itself' "$hdr" clamp -o "$work/itself.exr" "$work/itself.exr"
expect_status 0 'which is whole' "$hdr" png -o "$work/out/itself.png" "$work/itself.exr"

# a reader that goes away is no fault, and no word is said
to_nobody() { { "$hdr" "$@"; echo $? >"$work/pipe_status"; } | head -c 1 >/dev/null; }
for verb in $(verbs_of_kind format); do
    expect_status 0 "$verb to a reader that goes away" to_nobody "$verb" "$picture"
    check "$verb to a reader that goes away: ended by SIGPIPE" test "$(cat "$work/pipe_status")" -eq 141
    check "$verb to a reader that goes away: quiet" stderr_lines 0
done
expect_status 0 'a filter to a reader that goes away' to_nobody log "$picture"
check 'a filter to a reader that goes away: quiet' stderr_lines 0

# ---- Ended half way ----------------------------------------------------------------------------------------------

# Starts a run that waits for the rest of its input, and ends it by a signal once the output has been begun.
mkfifo "$work/feed"
end_half_way() {
    rm -rf "$work/out"
    mkdir "$work/out"
    { head -c $((size / 2)) "$picture" && exec sleep 60; } >"$work/feed" &
    feeder=$!
    # the shell lets its background processes ignore SIGINT
    env --default-signal=INT "$hdr" "$2" -o "$work/out/a.$2" <"$work/feed" 2>"$work/stderr" &
    killed=$!
    tries=0
    while empty_directory "$work/out" && [ $tries -lt 100 ]; do
        sleep 0.05
        tries=$((tries + 1))
    done
    check "$1, $2: it had begun to write" test "$tries" -lt 100
    sleep 0.1
    kill -s "$1" $killed
    wait $killed 2>/dev/null
    status=$?
    kill $feeder
    wait $feeder 2>/dev/null
    check "$1, $2: nothing under the output's name" absent "$work/out/a.$2"
}
if env --default-signal=INT true 2>/dev/null; then
    for ending in TERM:143 INT:130 HUP:129; do
        for format in $(verbs_of_kind format); do
            end_half_way "${ending%:*}" "$format"
            check "${ending%:*}, $format: ended by the signal" test "$status" -eq "${ending#*:}"
            check "${ending%:*}, $format: no temporary file" empty_directory "$work/out"
            check "${ending%:*}, $format: quiet" stderr_lines 0
        done
    done
    end_half_way KILL png
    check 'KILL: what is left is hidden' test -z "$(ls "$work/out")"
    rm -rf "$work/out"
    mkdir "$work/out"
else
    skip 'signals: env knows no --default-signal'
fi

# at any other moment: nothing, or all of it
absent_or_whole() { absent "$1" || cmp -s "$work/slow.png" "$1"; }
expect_status 0 'a slow run' "$hdr" log --reference : png -o "$work/slow.png" testdata/interior.exr
for moment in 00 01 02 03 04 05 06 07 08; do
    "$hdr" log --reference : png -o "$work/out/a.png" testdata/interior.exr 2>/dev/null &
    killed=$!
    sleep "0.$moment"
    kill -s TERM $killed 2>/dev/null
    wait $killed 2>/dev/null
    check "ended after 0.$moment s: nothing or all of it" absent_or_whole "$work/out/a.png"
    rm -f "$work/out/a.png"
    check "ended after 0.$moment s: nothing else" empty_directory "$work/out"
done

# ---- Formats and endings ----------------------------------------------------------------------------------------

refused 64 'a format and the ending of another' "$hdr" png -o "$work/out/a.exr" testdata/glossy.exr
expect_status 0 'a format and an ending of none' "$hdr" png -o "$work/out/a.picture" testdata/glossy.exr
rm -f "$work/out/a.picture"
refused 64 'nonsense in HDR_THREADS' env HDR_THREADS=many "$hdr" log -o "$work/out/a.exr" testdata/glossy.exr
refused 64 'nonsense in HDR_CPU' env HDR_CPU=fast "$hdr" log -o "$work/out/a.exr" testdata/glossy.exr

# ---- Bad pixels --------------------------------------------------------------------------------------------------

for verb in png exr log stats; do
    case $verb in
    stats) set -- "$hdr" stats ;;
    png) set -- "$hdr" png -o "$work/out/a.png" ;;
    *) set -- "$hdr" "$verb" -o "$work/out/a.exr" ;;
    esac
    refused 65 "$verb --strict" "$@" --strict "$specials"
    check "$verb --strict: one line" one_line_with "$specials"
done
expect_status 0 'special values' "$hdr" exr -o "$work/repaired.exr" "$specials"
check 'special values are counted, in one line' one_line_with '7 NaN'
check 'negative infinities are counted' stderr_has '7 -Inf'
check 'positive infinities are counted' stderr_has '7 +Inf'
expect_status 0 'special values, -q' "$hdr" png -q -o "$work/special.png" "$specials"
check '-q says nothing' stderr_lines 0
# several sweeps and clauses, and a second program, count them once all the same
expect_status 0 'special values in a long chain' "$hdr" divmax : log : srgb : png -o "$work/a.png" "$specials"
check 'a long chain counts them once' one_line_with '7 NaN'
in_a_pipe() { "$hdr" divmax "$specials" | "$hdr" log | "$hdr" png -o "$work/b.png"; }
expect_status 0 'special values through a pipe' in_a_pipe
check 'a pipe counts them once' one_line_with '7 NaN'
check 'a pipe gives the same picture' cmp -s "$work/a.png" "$work/b.png"

# What the pixels must be, by the table in testdata/tiny.c, from the bottom row up: the order of a PFM.
awk 'BEGIN {
    for (y = 3; y >= 0; y--) for (x = 0; x < 8; x++) {
        for (c = 0; c < 3; c++) v[c] = (x + y) % 2 ? 0.5 : 0.25
        if (y == 0 && x < 3) v[x] = 0
        if (y == 0 && x == 3) v[0] = v[1] = v[2] = 0
        if (y == 1 && x < 3) v[x] = 65504
        if (y == 1 && x == 3) v[0] = v[1] = v[2] = 65504
        if (y == 1 && x >= 4 && x < 7) v[x - 4] = 0
        if (y == 1 && x == 7) v[0] = v[1] = v[2] = 0
        if (y == 2 && x == 0) v[0] = 0
        if (y == 2 && x == 1) v[0] = v[1] = v[2] = 0
        if (y == 2 && x == 2) v[0] = 2 ^ -24
        if (y == 2 && x == 3) v[1] = 1023 * 2 ^ -24
        if (y == 2 && x == 4) v[2] = -(2 ^ -24)
        if (y == 2 && x == 5) v[0] = v[1] = v[2] = 2 ^ -24
        if (y == 2 && x == 6) v[0] = 65504
        if (y == 2 && x == 7) v[0] = v[1] = v[2] = 65504
        if (y == 3 && x == 7) { v[0] = 0; v[1] = 65504; v[2] = 0 }
        for (c = 0; c < 3; c++) printf "%.5e\n", v[c]
    }
}' >"$work/wanted"
"$hdr" pfm -q -o "$work/special.pfm" "$specials"
tail -c $((8 * 4 * 3 * 4)) "$work/special.pfm" | od -An -v -tf4 -w4 | awk '{ printf "%.5e\n", $1 + 0 }' | sed 's/^-0\.0*e+00$/0.00000e+00/' >"$work/read"
check 'special values are repaired, and their neighbours are as they were' cmp -s "$work/wanted" "$work/read"
"$hdr" png -o "$work/repaired.png" "$work/repaired.exr" 2>"$work/stderr"
check 'a repaired picture has nothing to repair' test "$(grep -c 'repaired components' "$work/stderr")" -eq 0
check 'a repaired picture gives the same codes' cmp -s "$work/special.png" "$work/repaired.png"

# ---- Encoded twice -----------------------------------------------------------------------------------------------

refused 65 'srgb then gamma' "$hdr" srgb : gamma : png -o "$work/out/a.png" "$picture"
check 'srgb then gamma: the clause is named' one_line_with 'clause 2 (gamma)'
expect_status 0 'srgb then gamma --force' "$hdr" srgb : gamma --force : png -o "$work/a.png" "$picture"
expect_status 0 'an encoded EXR' "$hdr" srgb -o "$work/encoded.exr" "$picture"
refused 65 'an encoded EXR, encoded again' "$hdr" srgb -o "$work/out/a.exr" "$work/encoded.exr"
refused 65 'an encoded EXR, encoded otherwise' "$hdr" gamma -o "$work/out/a.exr" "$work/encoded.exr"
expect_status 0 'an encoded EXR, --force' "$hdr" srgb --force -o "$work/a.exr" "$work/encoded.exr"
expect_status 0 'an encoded EXR to PNG' "$hdr" pfm -o "$work/encoded.pfm" "$work/encoded.exr"
"$hdr" srgb : pfm -o "$work/direct.pfm" "$picture"
check 'an encoded EXR is not encoded again' cmp -s "$work/direct.pfm" "$work/encoded.pfm"
expect_status 0 'an encoded EXR, decoded' "$hdr" srgb --decode : exr -o "$work/decoded.exr" "$work/encoded.exr"
"$hdr" info "$work/decoded.exr" >"$work/stdout"
check 'is linear again' grep -q 'state *linear' "$work/stdout"

finish test_status

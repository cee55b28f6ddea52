#!/bin/sh
# The manual, --help and the parser know the same options; the pages are up to date; every example runs.
. tests/cli/lib.sh

picture=$PWD/testdata/glossy.exr
verbs=$("$hdr" help --list | cut -f 1)
check 'there are verbs' test -n "$verbs"

# ---- The same options everywhere ---------------------------------------------------------------------------------

# options_in_help: from --help on standard input, as `hdr help --options` prints them: "--name" or "--name -l"
options_in_help() {
    sed -nE 's/^  -(.), --([a-z0-9-]+) .*/--\2 -\1/p; s/^      --([a-z0-9-]+) .*/--\1/p'
}

# items_in_page PAGE: the options that have an entry of their own, in the same form
items_in_page() {
    sed -nE 's/^\.It Fl (.) , Fl Fl ([a-z0-9-]+)( .*)?$/--\2 -\1/p; s/^\.It Fl Fl ([a-z0-9-]+)( .*)?$/--\1/p' "$1"
}

items_in_page man/hdr.1 >"$work/common"
check 'hdr(1) has options' test -s "$work/common"
for verb in $verbs; do
    page=man/hdr-$verb.1
    "$hdr" help --options "$verb" >"$work/options"
    "$hdr" "$verb" --help | options_in_help >"$work/help"
    check "$verb: --help has the options of the table" cmp -s "$work/options" "$work/help"
    if ! [ -e "$page" ]; then
        fail "there is no $page: make man"
        continue
    fi
    { items_in_page "$page" && cat "$work/common"; } >"$work/page"
    check "$verb: the manual has the options of the table" cmp -s "$work/options" "$work/page"
    # those of every verb are named on its page, too
    sed -nE 's/^\.Fl Fl ([a-z0-9-]+) [,.]$/--\1/p' "$page" >"$work/named"
    sed 's/ .*//' "$work/common" >"$work/common_names"
    check "$verb: its page names the options of every verb" cmp -s "$work/common_names" "$work/named"
    "$hdr" help --man "$verb" >"$work/now"
    check "$page is up to date (make man)" cmp -s "$work/now" "$page"
done
"$hdr" help --man >"$work/now"
check 'man/hdr.1 is up to date (make man)' cmp -s "$work/now" man/hdr.1
for page in man/hdr-*.1; do
    verb=${page#man/hdr-}
    check "$page: of a verb that there is" "$hdr" help --options "${verb%.1}" >/dev/null
done

mkdir "$work/bin" "$work/try"
cp "$picture" "$work/try/IN.exr"
"$hdr" mean --show mean-deviation -o "$work/try/SIGMA.exr" "$picture" "$picture"

# ---- The parser takes them, and the defaults are those that are told ---------------------------------------------

# result OPTION...: what the verb makes of the picture, in $work/result
result() {
    case $kind in
    filter) "$hdr" "$verb" -o "$work/result.exr" "$@" "$picture" && mv "$work/result.exr" "$work/result" ;;
    guided) "$hdr" "$verb" --sigma-picture="$work/try/SIGMA.exr" -o "$work/result.exr" "$@" "$picture" && mv "$work/result.exr" "$work/result" ;;
    join) "$hdr" "$verb" -o "$work/result.exr" "$@" "$picture" "$picture" && mv "$work/result.exr" "$work/result" ;;
    *)
        case $verb in
        # a chain stands behind it, and is told in the second line; times differ from run to run
        bench) "$hdr" "$verb" "$@" expose "$picture" >"$work/times" && sed 2d "$work/times" | tr -d '0-9.e -' >"$work/result" ;;
        error) "$hdr" "$verb" --against "$picture" "$@" "$picture" >"$work/result" ;;
        noise) "$hdr" "$verb" "$@" "$picture" "$picture" >"$work/result" ;;
        # without a picture
        crosscheck) "$hdr" "$verb" "$@" --only=gamma >"$work/result" ;;
        *) "$hdr" "$verb" "$@" "$picture" >"$work/result" ;;
        esac
        ;;
    esac
}

# help_line OPTION: what --help shows for it
help_line() {
    "$hdr" "$verb" --help | grep -E "^ *(-., )?$1( |\$)"
}

# An option of one mode only needs the option that chooses the mode: a flag, or one word of each option that has words.
modes() {
    for chooser in $("$hdr" help --options "$verb" | sed 's/ .*//'); do
        [ "$chooser" = "$1" ] && continue
        help_line "$chooser" | grep -qE -- "^ *(-., )?$chooser [^ ]" || printf '%s\n' "$chooser"
        for word in $(help_line "$chooser" | sed -n 's/.*(\([a-z0-9, -]* or [a-z0-9-]*\); default .*/\1/p' | sed 's/ or / /; s/,//g'); do
            printf '%s=%s\n' "$chooser" "$word"
        done
    done
}

"$hdr" help --list | cut -f 1,2 >"$work/list"
while read -r verb kind; do
    expect_status 0 "$verb without options" result
    cp "$work/result" "$work/plain"
    for option in $("$hdr" help --options "$verb" | sed 's/ .*//'); do
        case $verb$option in
        bench--reference | bench--plot) continue ;; # test_bench.sh is about them
        error--against | error--threshold) continue ;; # test_measure.sh
        error--flip-map) continue ;; # test_flip.sh
        noise--sampling-map | noise--deviation-map | noise--plot) continue ;; # test_noise.sh
        crosscheck--only | smooth--sigma-picture) continue ;; # result() gives it
        # test_ocio.sh is about them
        ocio--config | ocio--from | ocio--to | ocio--display | ocio--ocio-view | ocio--look | ocio--list) continue ;;
        esac
        case $option in
        --output) continue ;; # test_status.sh is about it
        --facts) continue ;; # test_shot.sh is about it
        --part | --layer | --channel | --crop) continue ;; # what a file holds: test_layers.sh is about them
        --help | --version)
            expect_status 0 "$verb $option" "$hdr" "$verb" "$option"
            continue
            ;;
        esac
        default=$(help_line "$option" | sed -n 's/.*[(;] *default \([^ ;]*\))$/\1/p')
        if help_line "$option" | grep -qE -- "^ *(-., )?$option [^ ]"; then
            check "$verb $option: help tells its default" test -n "$default"
            set -- "$option=$default"
        else
            check "$verb $option: a flag has no default" test -z "$default"
            set -- "$option"
        fi
        if result "$@" >"$work/stdout" 2>"$work/stderr"; then
            ok
            if [ -n "$default" ]; then check "$verb $*: is the default" cmp -s "$work/plain" "$work/result"; fi
            continue
        fi
        taken=
        for mode in $(modes "$option"); do
            if result "$mode" "$@" >"$work/stdout" 2>"$work/stderr"; then
                taken=$mode
                break
            fi
        done
        check "$verb $*: is accepted with some other option" test -n "$taken"
        [ -n "$taken" ] || continue
        cp "$work/result" "$work/with"
        result "$taken"
        check "$verb $*: is the default with $taken" cmp -s "$work/with" "$work/result"
    done
done <"$work/list"

# ---- The pages themselves ----------------------------------------------------------------------------------------

if command -v mandoc >/dev/null; then
    for page in man/*.[157]; do
        (cd man && mandoc -Tlint -W style "${page#man/}") >"$work/lint" 2>&1
        check "$page: $(head -n 1 "$work/lint")" test ! -s "$work/lint"
    done
else
    skip 'mandoc -Tlint: it is not there'
fi

# ---- Examples ----------------------------------------------------------------------------------------------------

ln -s "$hdr" "$work/bin/hdr"
for verb in $verbs; do ln -s hdr "$work/bin/hdr-$verb"; done

# example WHERE LINE: run as it stands, in a folder with a picture called IN.exr, and its deviation. It must make every OUT that it names, or print.
example() {
    (cd "$work/try" && PATH=$work/bin:$PATH sh -c "$2") >"$work/stdout" 2>"$work/stderr"
    status=$?
    check "$1: $2: status $status, $(head -n 1 "$work/stderr")" test $status -eq 0
    results=$(printf '%s\n' "$2" | grep -oE 'OUT[A-Za-z0-9_.-]*' | sort -u)
    for result in $results; do
        check "$1: $2: makes $result" test -s "$work/try/$result"
        case $result in
        *.png) check "$1: $2: $result is a PNG" is_png "$work/try/$result" ;;
        *.exr) check "$1: $2: $result is an EXR" is_exr "$work/try/$result" ;;
        esac
        rm -f "$work/try/$result"
    done
    if [ -z "$results" ]; then check "$1: $2: prints" test -s "$work/stdout"; fi
}

# mdoc's escapes undone
plain_text() {
    sed 's/\\&//g; s/\\-/-/g; s/\\(ha/^/g; s/\\(ti/~/g; s/\\(ga/`/g; s/\\(aq/'\''/g; s/\\(dq/"/g; s/\\e/\\/g'
}

# The command lines among a page's displays.
commands_in_page() {
    sed -n '/^\.Bd -literal/,/^\.Ed/p' "$1" | plain_text | grep -E '^hdr(-[a-z]+)? '
}

for verb in $verbs; do
    "$hdr" "$verb" --help | sed -n '/^Examples:$/,/^$/s/^  //p' >"$work/in_help"
    commands_in_page "man/hdr-$verb.1" >"$work/in_page"
    check "$verb: has an example" test -s "$work/in_help"
    check "$verb: the same examples in --help and manual" cmp -s "$work/in_help" "$work/in_page"
    check "$verb: its examples are about it" test "$(grep -cE "(^|[ |-])$verb( |\$)" "$work/in_help")" -eq "$(wc -l <"$work/in_help")"
done
for page in man/*.[157]; do
    commands_in_page "$page" >"$work/commands"
    # descriptor 3: a command must not eat the list
    while read -r line <&3; do
        example "$page" "$line"
    done 3<"$work/commands"
done

# hdrpipe(5) shows a command and what it prints.
head_command=$(sed -n '/^\.Bd -literal/,/^\.Ed/p' man/hdrpipe.5 | plain_text | grep -E '^hdr-.*\| head')
sed -n '/^hdrpipe 1$/,/^\.Ed/p' man/hdrpipe.5 | plain_text | grep -v '^\.Ed' >"$work/shown"
(cd "$work/try" && PATH=$work/bin:$PATH sh -c "$head_command") >"$work/printed"
check 'hdrpipe(5) shows a head' test -s "$work/shown"
check 'hdrpipe(5) shows what is printed' cmp -s "$work/shown" "$work/printed"

finish test_man

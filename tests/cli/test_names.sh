#!/bin/sh
# Names in a file may hold any byte: what is printed for people holds none that acts on a terminal.
. tests/cli/lib.sh

# little NUMBER: four bytes.
little() {
    # shellcheck disable=SC2059 # the bytes are the format
    printf "$(printf '\\%03o\\%03o\\%03o\\%03o' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24 & 255)))"
}

# attribute NAME TYPE VALUE: the last as printf's format.
attribute() {
    # shellcheck disable=SC2059
    printf "$3" >"$work/value"
    printf '%s\000%s\000' "$1" "$2"
    little "$(wc -c <"$work/value")"
    cat "$work/value"
}

# exr_with NAME: an EXR of one pixel, its only channel called so (as printf's format), and another name of that kind.
exr_with() {
    one='\001\000\000\000' zero='\000\000\000\000'
    {
        printf '\166\057\061\001\002\000\000\000'
        attribute channels chlist "$1\\000\\002\\000\\000\\000$zero$one$one\\000"
        attribute compression compression '\000'
        attribute dataWindow box2i "$zero$zero$zero$zero"
        attribute displayWindow box2i "$zero$zero$zero$zero"
        attribute lineOrder lineOrder '\000'
        attribute pixelAspectRatio float '\000\000\200\077'
        attribute screenWindowCenter v2f "$zero$zero"
        attribute screenWindowWidth float '\000\000\200\077'
        attribute name string "$1"
        attribute comments string "$1"
        printf '\000'
    } >"$work/head"
    {
        cat "$work/head"
        little $(($(wc -c <"$work/head") + 8))
        little 0
        little 0
        little 4
        printf '\000\000\200\077'
    } >"$work/name.exr"
}

# escape, DEL, U+009B in UTF-8 and as a byte, an e with an accent, half a character
exr_with 'a\033[7m\177\302\233\233\303\251\303.R'
shown=$(printf 'a?[7m???\303\251?')
for words in info stats 'info --part 0' 'info --layer a'; do
    # shellcheck disable=SC2086 # they are several words
    "$hdr" $words "$work/name.exr" >"$work/stdout" 2>"$work/stderr"
    check "$words: no control characters" test -z "$(tr -d '\n' <"$work/stdout" | LC_ALL=C tr -dc '\001-\037\177\233')"
done
expect_status 0 'a layer' "$hdr" stats --channel R --part 0 --layer "$(printf 'a\033[7m\177\302\233\233\303\251\303')" \
    "$work/name.exr"
check 'its name, as far as it can be shown' grep -qF "layer              $shown" "$work/stdout"
check 'the channel' grep -qF "$shown.R float" "$work/stdout"
expect_status 0 'info' "$hdr" info --channel "$(printf 'a\033[7m\177\302\233\233\303\251\303.R')" "$work/name.exr"
check 'the part' grep -qF "part               0 $shown.R" "$work/stdout"
check 'the listed layer' grep -qF "layer $shown" "$work/stdout"
check 'the attribute' grep -qF "comments (string) $shown.R" "$work/stdout"

expect_status 0 'info --json' "$hdr" info --json --channel "$(printf 'a\033[7m\177\302\233\233\303\251\303.R')" "$work/name.exr"
check 'info --json: escaped' grep -qF "$(printf '"a\\u001B[7m\\u007F\\u009B\\u009B\303\251\\u00C3.R"')" "$work/stdout"

# a file's own name
control=$(printf '\033[7m')
cp testdata/tiny/one.exr "$work/${control}a.exr"
for verb in info stats; do
    expect_status 0 "$verb of an odd name" "$hdr" "$verb" "$work/${control}a.exr"
    check "$verb of an odd name" test "$(head -n 1 "$work/stdout")" = "$work/?[7ma.exr"
done
expect_status 0 'explaining an odd name' "$hdr" png -v -o "$work/a.png" "$work/${control}a.exr"
check 'explaining an odd name: no control characters' test -z "$(tr -dc '\033' <"$work/stderr")"

finish test_names

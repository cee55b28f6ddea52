#!/bin/sh
# ocio: names and what is wrong with them, the state that it leaves, pipes, and the codes that other programs make by the same
# configuration.
. tests/cli/lib.sh
unset OCIO OCIO_ACTIVE_DISPLAYS OCIO_ACTIVE_VIEWS

picture=testdata/glossy.exr
aces=src/plugin/aces.ocio
mkdir "$work/out"

# ---- Without the plug-in -------------------------------------------------------------------------------------------

elsewhere=$work/elsewhere
mkdir -p "$elsewhere"
cp "$hdr" "$elsewhere/hdr" || exit 1
if "$elsewhere/hdr" ocio --list >"$work/stdout" 2>"$work/stderr"; then
    skip 'a plug-in is installed where all programs look for it'
else
    expect_status 65 'without the plug-in' "$elsewhere/hdr" ocio -o "$work/out/a.png" "$picture"
    check 'one line' stderr_lines 1
    check 'it says what is missing' stderr_has 'plug-in hdrpipe-ocio.so, which is not installed'
    check 'it names the packages' stderr_has libopencolorio-dev
    check 'nothing is written' empty_directory "$work/out"
    expect_status 0 'others do without' "$elsewhere/hdr" srgb -o "$work/a.png" "$picture"
    expect_status 0 'so does its help' "$elsewhere/hdr" ocio --help
fi

# ---- Words that make no command: before any file is opened, and without the plug-in --------------------------------

# misused WORD OPTION...
misused() {
    word=$1
    shift
    expect_status 64 "ocio $*" "$elsewhere/hdr" ocio "$@" -o "$work/out/a.png" "$work/missing.exr"
    check "ocio $*: says '$word'" stderr_has "$word"
    check "ocio $*: nothing is written" empty_directory "$work/out"
}
misused 'only one of them' --to ACEScg --display 'sRGB - Display'
misused 'only one of them' --to ACEScg --ocio-view Raw
misused 'is no name' --to ''
misused 'is no name' --config=

if ! [ -e "$BUILD/plugin/hdrpipe-ocio.so" ]; then
    skip 'there is no plug-in: no C++ compiler, or no headers of OpenColorIO'
    finish test_ocio
    exit
fi

# ---- Names ---------------------------------------------------------------------------------------------------------

expect_status 0 'its names' "$hdr" ocio --list
for name in ACES2065-1 ACEScg ACEScct 'Linear Rec.709 (sRGB)' 'sRGB - Texture' 'sRGB - Display' 'ACES 1.0 - SDR Video' Un-tone-mapped \
    'scene_linear: Linear Rec.709 (sRGB)' 'ACES 1.3 Reference Gamut Compression'; do
    check "there is $name" grep -qx " *$name" "$work/stdout"
done
cp "$work/stdout" "$work/built_in"
expect_status 0 'names of a file' "$hdr" ocio --list --config "$aces"
check 'the file is what is built in' cmp -s "$work/stdout" "$work/built_in"
by_environment() { OCIO=$aces "$hdr" ocio --list; }
expect_status 0 'names of the environment' by_environment
check 'they are the same' cmp -s "$work/stdout" "$work/built_in"
check 'it prints nothing else' stderr_lines 0
expect_status 0 'as JSON' "$hdr" ocio --list --json
check 'a display has its views' grep -q '"sRGB - Display": \["ACES 1.0 - SDR Video", ' "$work/stdout"
check 'on one line' test "$(wc -l <"$work/stdout")" -eq 1
if command -v python3 >/dev/null; then
    check 'it is JSON' python3 -c 'import json, sys; json.load(open(sys.argv[1]))' "$work/stdout"
else
    skip 'no python3 to read JSON with'
fi
expect_status 64 'a list and a file' "$hdr" ocio --list "$picture"
expect_status 64 'a list in a file' "$hdr" ocio --list -o "$work/out/a.txt"

# unknown WORD OPTION...: 64, with what there is
unknown() {
    word=$1
    shift
    expect_status 64 "ocio $*" "$hdr" ocio "$@" -o "$work/out/a.png" "$picture"
    check "ocio $*: one line" stderr_lines 1
    check "ocio $*: lists '$word'" stderr_has "$word"
    check "ocio $*: nothing is written" empty_directory "$work/out"
}
unknown "'nonesuch' is none of the colour spaces that the configuration has: CIE-XYZ-D65, " --to nonesuch
unknown 'ACEScg' --from nonesuch
unknown 'Rec.2100-PQ - Display' --display nonesuch
unknown "views of 'P3-D65 - Display' that the configuration has: ACES 1.0 - SDR Cinema" --display 'P3-D65 - Display' --ocio-view nonesuch
unknown 'Un-tone-mapped' --ocio-view nonesuch
unknown 'ACES 1.3 Reference Gamut Compression' --look nonesuch
unknown "'nonesuch'" --look '+ACES 1.3 Reference Gamut Compression, -nonesuch' --to ACEScg

# ---- Configurations ------------------------------------------------------------------------------------------------

# faulty STATUS WORD COMMAND...: one line with the word, which does not blame the picture
faulty() {
    wanted=$1 word=$2
    shift 2
    expect_status "$wanted" "$*" "$@"
    check "$*: says '$word'" stderr_has "$word"
    check "$*: one line" stderr_lines 1
    check "$*: it is not the picture's fault" test "$(grep -c glossy "$work/stderr")" -eq 0
    check "$*: nothing is written" empty_directory "$work/out"
}
faulty 66 'missing.ocio: No such file' "$hdr" ocio --config "$work/missing.ocio" -o "$work/out/a.png" "$picture"
faulty 66 'missing.ocio: No such file' "$hdr" ocio --list --config "$work/missing.ocio"
of_environment() { OCIO=$work/missing.ocio "$hdr" "$@"; }
# shellcheck disable=SC2016 # the program's own words
faulty 66 '$OCIO' of_environment ocio -o "$work/out/a.png" "$picture"
echo 'ocio_profile_version: [' >"$work/broken.ocio"
faulty 65 broken.ocio "$hdr" ocio --config "$work/broken.ocio" -o "$work/out/a.png" "$picture"
faulty 66 directory "$hdr" ocio --config "$work" -o "$work/out/a.png" "$picture"
unset_environment() { OCIO='' "$hdr" "$@"; }
expect_status 0 'an empty OCIO is none' unset_environment ocio -o "$work/a.png" "$picture"

# one with a look-up table that is not there, and no role, display or encoding
cat >"$work/own.ocio" <<'END'
ocio_profile_version: 2
search_path: luts
file_rules:
  - !<Rule> {name: Default, colorspace: base}
roles:
  scene_linear: base
displays:
  monitor:
    - !<View> {name: plain, colorspace: twice}
    - !<View> {name: bent, colorspace: square}
    - !<View> {name: raw, colorspace: numbers}
looks:
  - !<Look> {name: half, process_space: base, transform: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}}
colorspaces:
  - !<ColorSpace> {name: base, aliases: [other name]}
  - !<ColorSpace> {name: twice, from_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}}
  - !<ColorSpace> {name: square, from_scene_reference: !<ExponentTransform> {value: 2}}
  - !<ColorSpace> {name: swapped, from_scene_reference: !<MatrixTransform> {matrix: [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}}
  - !<ColorSpace> {name: beyond, from_scene_reference: !<MatrixTransform> {matrix: [1e38, 0, 0, 0, 0, 1e38, 0, 0, 0, 0, 1e38, 0, 0, 0, 0, 1]}}
  - !<ColorSpace> {name: tabled, from_scene_reference: !<FileTransform> {src: missing.cube}}
  - !<ColorSpace> {name: numbers, isdata: true}
  - !<ColorSpace> {name: grey, from_scene_reference: !<MatrixTransform> {matrix: [0.25, 0.5, 0.25, 0, 0.25, 0.5, 0.25, 0, 0.25, 0.5, 0.25, 0, 0, 0, 0, 1]}}
END
own() { "$hdr" ocio --config "$work/own.ocio" "$@"; }
faulty 66 missing.cube own --to tabled -o "$work/out/a.png" "$picture"
sed '/scene_linear/d; s/^roles:/roles: {}/' "$work/own.ocio" >"$work/roleless.ocio"
faulty 64 'no role scene_linear' "$hdr" ocio --config "$work/roleless.ocio" --to twice -o "$work/out/a.png" "$picture"
expect_status 0 'without that role' "$hdr" ocio --config "$work/roleless.ocio" --from base --to twice -o "$work/a.exr" "$picture"

mkfifo "$work/config.fifo"
cat "$work/own.ocio" >"$work/config.fifo" &
expect_status 66 'a configuration from a pipe' "$hdr" ocio --config "$work/config.fifo" --to twice -o "$work/a.exr" "$picture"
wait
check 'that is said' stderr_has 'has to be a file'
sed 's/scene_linear: base/scene_linear: gone/' "$work/own.ocio" >"$work/gone.ocio"
faulty 65 'does not have' "$hdr" ocio --config "$work/gone.ocio" --to twice -o "$work/out/a.png" "$picture"
expect_status 64 'a list behind a program' "$hdr" ocio --list : stats "$picture"

# ---- What it makes -------------------------------------------------------------------------------------------------

# numbers NAME WANTED OPTION...: of a picture of one pixel (0.25, 0.5, 0.125)
printf 'PF\n1 1\n-1\n\0\0\200\076\0\0\0\077\0\0\0\076' >"$work/one.pfm"
numbers() {
    name=$1 wanted=$2
    shift 2
    own "$@" : pfm -o "$work/one_out.pfm" "$work/one.pfm" 2>"$work/stderr"
    found=$(tail -c 12 "$work/one_out.pfm" | od -An -tf4 | tr -s ' ' | sed 's/^ //; s/ $//')
    check "$name: '$found' and not '$wanted'" test "$found" = "$wanted"
}
numbers 'a space' '0.5 1 0.25' --to twice
numbers 'a space without a way back' '0.34375 0.34375 0.34375' --to grey
numbers 'from another' '0.125 0.25 0.0625' --from twice --to base
numbers 'by an alias' '0.5 1 0.25' --from 'other name' --to twice
numbers 'by a role' '0.125 0.25 0.0625' --from twice --to scene_linear
numbers 'channels in their order' '0.5 0.25 0.125' --to swapped
numbers 'the first view' '0.5 1 0.25'
numbers 'a view' '0.0625 0.25 0.015625' --display monitor --ocio-view bent
numbers 'a look' '0.25 0.5 0.125' --look half
numbers 'a look the other way' '1 2 0.5' --look -half
numbers 'a look between spaces' '0.25 0.5 0.125' --to twice --look half
numbers 'data are left alone' '0.25 0.5 0.125' --to numbers
"$hdr" expose --ev 120 : ocio --config "$work/own.ocio" --to beyond : pfm -o "$work/one_out.pfm" "$work/one.pfm"
check 'what is infinite is held' test "$(tail -c 12 "$work/one_out.pfm" | od -An -tx4 | tr -d ' ')" = 7f7fffff7f7fffff7f7fffff

# leaves STATE OPTION...
leaves() {
    wanted=$1
    shift
    own "$@" -o "$work/state.exr" "$picture"
    "$hdr" info "$work/state.exr" >"$work/stdout"
    check "$*: is $wanted then" grep -q "$wanted" "$work/stdout"
}
leaves linear --to twice
leaves linear --to numbers
leaves ocio --ocio-view raw
leaves ocio --to grey
leaves ocio --to square
leaves linear --ocio-view plain
leaves ocio --ocio-view bent
leaves_aces() {
    wanted=$1
    shift
    "$hdr" ocio "$@" -o "$work/state.exr" "$picture"
    "$hdr" info "$work/state.exr" >"$work/stdout"
    check "$*: is $wanted then" grep -q "$wanted" "$work/stdout"
}
leaves_aces ocio
leaves_aces linear --to ACEScg
leaves_aces ocio --to ACEScct
leaves_aces ocio --ocio-view Raw
"$hdr" ocio -o "$work/encoded.exr" "$picture"
expect_status 65 'encoded again' "$hdr" srgb -o "$work/out/a.png" "$work/encoded.exr"
expect_status 65 'encoded before' "$hdr" srgb : ocio -o "$work/out/a.png" "$picture"
check 'that is said' stderr_has 'encoded already (srgb)'
check 'nothing is written' empty_directory "$work/out"
expect_status 0 'encoded before, as --from says' "$hdr" srgb : ocio --from 'sRGB - Texture' --to 'Linear Rec.709 (sRGB)' -o "$work/a.exr" "$picture"
"$hdr" ocio -o "$work/a.png" "$picture"
"$hdr" png --explain -o "$work/b.png" "$work/encoded.exr" 2>"$work/stderr"
check 'a PNG of it is not encoded again' test "$(grep -c srgb "$work/stderr")" -eq 0
"$hdr" ocio : pfm -q -o "$work/a.pfm" "$picture"
"$hdr" pfm -q -o "$work/b.pfm" "$work/encoded.exr"
check 'an EXR of it has the same floats' cmp -s "$work/a.pfm" "$work/b.pfm"
for chunk in sRGB gAMA cHRM cICP; do
    check "a PNG of it has no $chunk" test "$(head -c 200 "$work/a.png" | grep -ac $chunk)" -eq 0
done

# pictures of all kinds: the same bytes by any number of threads, whatever is skipped, by the slow way
for file in testdata/tiny/*.exr; do
    "$hdr" ocio : png -j 1 -q -o "$work/a.png" "$file"
    for how in '-j 2' '-j 5' --no-skip --reference '--memory 1M'; do
        # shellcheck disable=SC2086 # two words
        "$hdr" ocio : png $how -q -o "$work/b.png" "$file"
        check "$file: $how" cmp -s "$work/a.png" "$work/b.png"
    done
done
"$hdr" ocio -o "$work/a.pfm" testdata/tiny/grey.exr
check 'one plane becomes three' test "$(head -c 2 "$work/a.pfm")" = PF

# other primaries are converted for the configuration that is built in, and left to --from elsewhere
foreign=testdata/tiny/foreign.exr
"$hdr" ocio --to 'Linear Rec.709 (sRGB)' -o "$work/a.exr" "$foreign"
"$hdr" pfm -q -o "$work/a.pfm" "$foreign"
own --to base : pfm -o "$work/b.pfm" "$foreign"
check 'left alone' cmp -s "$work/a.pfm" "$work/b.pfm"
"$hdr" ocio --to 'Linear Rec.709 (sRGB)' --explain : pfm -o "$work/b.pfm" "$foreign" 2>"$work/stderr"
check 'converted' stderr_has 'primaries are converted to Rec.709'
"$hdr" ocio --from ACEScg --to ACEScg --explain : pfm -o "$work/b.pfm" "$foreign" 2>"$work/stderr"
check 'not with --from' cmp -s "$work/a.pfm" "$work/b.pfm"
"$hdr" info --json "$work/a.exr" >"$work/stdout"
check 'what is linear Rec.709 claims no other primaries' grep -q '"assumed": true' "$work/stdout"
# primaries that are known by the space's name are told, and converted from; others are said not to be
"$hdr" ocio --to ACEScg -o "$work/acescg.exr" "$picture"
"$hdr" info "$work/acescg.exr" >"$work/stdout"
check 'AP1 is told' grep -q 'red 0.713,0.293 .*white 0.32168,0.33767' "$work/stdout"
"$hdr" png -q --bits 16 -o "$work/direct.png" "$picture"
"$hdr" ocio --to ACEScg : png -q --bits 16 -o "$work/back.png" "$picture"
check 'a PNG by way of AP1 tells sRGB, too' grep -aq sRGB "$work/back.png"
if command -v idiff >/dev/null; then
    check 'and has the same codes but for the last places' idiff -q -fail 0.0005 "$work/direct.png" "$work/back.png"
else
    skip 'idiff: it is not there'
fi
expect_status 0 'primaries that nobody knows' own --to twice -o "$work/a.exr" "$picture"
check 'that is said' one_line_with 'which primaries its colours have is not known'
expect_status 0 'those of a view' own --ocio-view bent -o "$work/a.exr" "$picture"
check 'need not be' stderr_lines 0

# ---- Pipes ---------------------------------------------------------------------------------------------------------

"$hdr" ocio "$picture" | cat >"$work/piped"
check 'it sends pixels' is_exr "$work/piped"
"$hdr" log "$picture" | "$hdr" ocio --config "$work/own.ocio" --to square | "$hdr" clamp | "$hdr" pfm -q >"$work/a.pfm"
"$hdr" log : ocio --config "$work/own.ocio" --to square : clamp : pfm -q -o "$work/b.pfm" "$picture"
check 'a pipe and a chain' cmp -s "$work/a.pfm" "$work/b.pfm"
printf 'hdrpipe 1\nthen ocio\n\n' | cat - "$picture" >"$work/headed"
expect_status 65 'in a head' "$hdr" png -o "$work/out/a.png" "$work/headed"
check 'in a head: it says why' stderr_has 'ocio cannot come through a pipe'
check 'nothing is written' empty_directory "$work/out"

# ---- The codes of others -------------------------------------------------------------------------------------------

# within_a_code NAME A B
within_a_code() {
    idiff -q -warn 1 -fail 0.0042 -failpercent 0 "$2" "$3" >"$work/stdout" 2>&1
    check "$1: within one code of oiiotool" test $? -le 1
}
if command -v oiiotool >/dev/null && command -v idiff >/dev/null; then
    for file in testdata/glossy.exr testdata/interior.exr; do
        "$hdr" ocio -o "$work/a.png" "$file"
        oiiotool "$file" --ch R,G,B --colorconfig "$aces" --ociodisplay:from='Linear Rec.709 (sRGB)' 'sRGB - Display' 'ACES 1.0 - SDR Video' \
            -d uint8 -o "$work/b.png" >"$work/log" 2>&1
        within_a_code "$file for sRGB" "$work/a.png" "$work/b.png"
        "$hdr" ocio --from ACEScg --display 'Rec.2100-PQ - Display' --ocio-view 'ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)' -o "$work/a.png" "$file"
        oiiotool "$file" --ch R,G,B --colorconfig "$aces" --ociodisplay:from=ACEScg 'Rec.2100-PQ - Display' \
            'ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)' -d uint8 -o "$work/b.png" >"$work/log" 2>&1
        within_a_code "$file for PQ" "$work/a.png" "$work/b.png"
        "$hdr" ocio --to ACEScct -o "$work/a.png" "$file"
        oiiotool "$file" --ch R,G,B --colorconfig "$aces" --colorconvert 'Linear Rec.709 (sRGB)' ACEScct -d uint8 -o "$work/b.png" >"$work/log" 2>&1
        within_a_code "$file in ACEScct" "$work/a.png" "$work/b.png"
    done
else
    skip 'there is no oiiotool or idiff'
fi

finish test_ocio

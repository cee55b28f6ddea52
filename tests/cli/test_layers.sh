#!/bin/sh
# Parts, layers, views, channels, levels and rectangles: however the file comes in, the same bytes come out; and they are
# those that other tools read, where these are installed.
. tests/cli/lib.sh

corpus=${HDRPIPE_CORPUS:-../shared/corpus}
storage=$corpus/storage

same_bytes() {
    cmp -s "$1" "$2"
}

# ways NAME FILE OPTION...: a chain with reading options on a file, on standard input, behind a pipe, and handed on by a
# filter that was given the options, which the next programs do not know.
ways() {
    name=$1 file=$2
    shift 2
    expect_status 0 "$name" "$hdr" log "$@" : png -o "$work/file.png" "$file"
    expect_status 0 "$name, < file" "$hdr" log "$@" : png -o "$work/input.png" <"$file"
    # shellcheck disable=SC2002 # it is to be a pipe
    cat "$file" | "$hdr" log : png "$@" -o "$work/cat.png"
    "$hdr" log "$@" <"$file" | "$hdr" png -o "$work/filter.png"
    "$hdr" log "$@" "$file" | cat | "$hdr" png "$@" -o "$work/repeated.png"
    for way in input cat filter repeated; do
        check "$name: $way gives the same bytes" same_bytes "$work/file.png" "$work/$way.png"
    done
    expect_status 0 "$name: info" "$hdr" info --json "$@" "$file"
    rm -f "$work"/*.png
}

# alike NAME FILE OPTIONS -- OPTIONS: both choices are the same picture.
alike() {
    name=$1 file=$2 first=$3 second=$4
    # shellcheck disable=SC2086 # they are several words
    "$hdr" exr $first -o "$work/first.exr" "$file" && "$hdr" exr $second -o "$work/second.exr" "$file"
    check "$name: $first and $second" same_bytes "$work/first.exr" "$work/second.exr"
}

# refused NAME WORD FILE OPTION...: bad data, in one line that has the word.
refused() {
    name=$1 word=$2 file=$3
    shift 3
    expect_status 65 "$name" "$hdr" png "$@" -o "$work/refused.png" "$file"
    check "$name: one line that says it" one_line_with "$word"
    check "$name: nothing is written" absent "$work/refused.png"
}

# ---- Words -------------------------------------------------------------------------------------------------------

for words in '--level -1' '--level x' '--level proxy:' '--level proxy:0' '--level 1.5' '--crop 1,2,3' '--crop 0,0,0,5' \
    '--crop 0,0,5,5,5' '--crop 2147483647,0,2,1' '--crop a,b,c,d' '--part=' '--layer=' '--channel='; do
    # shellcheck disable=SC2086 # they are several words
    expect_status 64 "$words" "$hdr" png $words -o "$work/a.png" testdata/tiny/ramp.exr
done
printf 'hdrpipe 1\nread --crop 1,2\nthen log\n\n' | cat - testdata/tiny/ramp.exr >"$work/head"
expect_status 65 'a head with a wrong rectangle' "$hdr" png -o "$work/a.png" "$work/head"
"$hdr" log --layer a <testdata/tiny/ramp.exr | "$hdr" png --layer b -o "$work/a.png" 2>"$work/stderr"
check 'two layers in one pipe' stderr_has 'says a, another b'
refused 'a level of lines' 'no level 1' testdata/tiny/ramp.exr --level 1
refused 'a layer that is not there' 'no layer or view diffuse' testdata/tiny/ramp.exr --layer diffuse

# ---- Rectangles --------------------------------------------------------------------------------------------------

for crop in 0,0,400,300 17,33,100,50 399,299,1,1 -20,-10,500,400 390,-5,100,30; do
    ways "crop $crop" testdata/interior.exr --crop "$crop"
done
# a rectangle is the same as a file that holds no more
"$hdr" exr --crop 40,50,120,90 -o "$work/piece.exr" testdata/interior.exr
for chain in log 'expose --auto : log --mode range' 'divmax --percentile 99'; do
    # shellcheck disable=SC2086 # it is several words
    "$hdr" $chain : pfm --crop 40,50,120,90 -o "$work/cropped.pfm" testdata/interior.exr
    # shellcheck disable=SC2086
    "$hdr" $chain : pfm -o "$work/piece.pfm" "$work/piece.exr"
    check "$chain of a rectangle" same_bytes "$work/cropped.pfm" "$work/piece.pfm"
    # shellcheck disable=SC2086
    "$hdr" $chain : pfm --crop 40,50,120,90 -j 1 --memory 1M --no-skip -o "$work/again.pfm" testdata/interior.exr
    check "$chain of a rectangle, decoded again" same_bytes "$work/cropped.pfm" "$work/again.pfm"
done
# nothing of the picture: black
for verb in $(verbs_of_kind filter); do
    expect_status 0 "$verb of nothing" "$hdr" "$verb" : png --crop 5000,5000,8,8 -o "$work/black.png" testdata/interior.exr
    expect_status 0 "$verb of nothing, with alpha" "$hdr" "$verb" : exr --crop 5000,5000,8,8 -o "$work/black.exr" \
        testdata/tiny/alpha.exr
done
expect_status 0 'facts of nothing' "$hdr" stats --json --crop 5000,5000,8,8 testdata/interior.exr
check 'nothing is lit' grep -q '"lit": 0' "$work/stdout"
expect_status 65 'the data window of nothing' "$hdr" png --window data --crop 5000,5000,8,8 -o "$work/a.png" \
    testdata/interior.exr

# ---- Levels ------------------------------------------------------------------------------------------------------

if command -v exrmaketiled >/dev/null; then
    for mode in '-m -d' '-m -u' '-r -d' '-r -u'; do
        # shellcheck disable=SC2086
        exrmaketiled $mode -t 32 48 testdata/interior.exr "$work/levels.exr"
        for level in 0 1 2 5 8; do
            ways "exrmaketiled $mode, level $level" "$work/levels.exr" --level "$level"
        done
        ways "exrmaketiled $mode, a proxy" "$work/levels.exr" --level proxy:60
        ways "exrmaketiled $mode, a rectangle of a level" "$work/levels.exr" --level 1 --crop 30,40,50,60
        alike "exrmaketiled $mode" "$work/levels.exr" '--level 2' '--level proxy:100'
        alike "exrmaketiled $mode" "$work/levels.exr" '--level 0' '--level proxy:401'
    done
else
    skip 'there is no exrmaketiled'
fi

# ---- Real files --------------------------------------------------------------------------------------------------

if ! [ -d "$storage" ]; then
    skip "there is no $storage"
    finish test_layers
    exit
fi
parts=$storage/beachball_multipart.exr layers=$storage/beachball_layers.exr
ways 'a view that is a part' "$parts" --layer left
ways 'a part' "$parts" --part rgba_left
ways 'a channel of a part' "$parts" --part depth_right --channel Z
ways 'a channel in a layer' "$parts" --channel forward.u
ways 'a part, cropped' "$parts" --part 4 --crop 700,300,400,200
alike multipart "$parts" '--layer left' '--part 4'
alike multipart "$parts" '--layer LEFT' '--part rgba_left'
alike multipart "$parts" '--part 0' '--layer right'
alike multipart "$parts" '--layer left --channel Z' '--part depth_left --channel Z'
for view in left right; do # each part has its own header
    "$hdr" exr --channel Z --part "depth_$view" -o "$work/view.exr" "$parts"
    check "the attributes of part depth_$view" test "$("$hdr" info "$work/view.exr" | grep -c "view (string) $view")" = 1
done
ways 'a view that is a layer' "$layers" --layer left
ways 'a channel' "$layers" --channel whitebarmask.left.mask
alike layers "$layers" '--layer right' '--part 0'
alike layers "$layers" '--layer forward.left --channel u' '--channel forward.left.u'
refused 'a layer without colours' 'no layer or view forward' "$parts" --layer forward
refused 'a part that is not there' 'no part 10' "$parts" --part 10
refused 'a part of one part' 'a file of one part' "$storage/Adjuster.exr" --part 1
for view in center left right; do
    ways "Adjuster, $view" "$storage/Adjuster.exr" --layer "$view"
done
for level in 0 1 3 9 proxy:200; do
    ways "Bonita, level $level" "$storage/Bonita.exr" --level "$level"
done
expect_status 65 'info of deep data' "$hdr" info --json "$storage/deep_trunks.exr"
check 'it is listed all the same' grep -q '"storage": "deep scan-line"' "$work/stdout"

# Only the chosen part's chunks are read: what stands in front of each begins with the part's number.
if command -v strace >/dev/null && strace -o "$work/trace" true 2>/dev/null; then
    strace -f -e trace=pread64 -e read=all -s 16 -xx -o "$work/trace" "$hdr" exr --part 4 -j 1 -o "$work/a.exr" "$parts"
    grep -oE 'pread64.*"\\x..\\x00\\x00\\x00.*, 12, [0-9]+\) += 12$' "$work/trace" >"$work/leaders"
    leaders=$(grep -c '"\\x04' "$work/leaders")
    others=$(grep -cv '"\\x04' "$work/leaders")
    check "876 chunks or more are read: $leaders" test "$leaders" -ge 876
    check "none of another part: $others" test "$others" -eq 0
else
    skip 'there is no strace'
fi

# as_others_read NAME FILE OPTIONS -- OIIOTOOL'S WORDS
as_others_read() {
    name=$1 file=$2 ours=$3 theirs=$4
    # shellcheck disable=SC2086
    "$hdr" exr $ours -o "$work/ours.exr" "$file"
    # shellcheck disable=SC2086
    oiiotool "$file" $theirs -d float -o "$work/theirs.exr"
    check "$name as oiiotool reads it" oiiotool "$work/ours.exr" "$work/theirs.exr" --diff >/dev/null
}
if command -v oiiotool >/dev/null; then
    as_others_read 'rgba_left' "$parts" '--part 4' '--subimage 4'
    as_others_read 'depth_left' "$parts" '--channel Z' '--subimage 1'
    as_others_read 'Bonita, level 2' "$storage/Bonita.exr" '--level 2' '--selectmip 2'
    as_others_read 'Adjuster, left' "$storage/Adjuster.exr" '--layer left' '--ch R=left.R,G=left.G,B=left.B'
else
    skip 'there is no oiiotool'
fi

finish test_layers

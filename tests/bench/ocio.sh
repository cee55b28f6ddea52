#!/bin/sh
# ocio.sh [FILE] [REPETITIONS]: a view for sRGB, and a conversion of colour spaces, EXR to PNG, beside oiiotool and ocioconvert
# where they are installed, all by the configuration that hdrpipe has built in. Interleaved repetitions, medians, ratios, and
# how far the codes are apart.
. tests/bench/lib.sh
picture "${1:-}"
aces=src/plugin/aces.ocio
from='Linear Rec.709 (sRGB)' display='sRGB - Display' view='ACES 1.0 - SDR Video'

i=0
while [ "$i" -lt "${2:-5}" ]; do
    time_of view "$hdr ocio : png -o $work/view.png $file"
    time_of convert "$hdr ocio --to 'sRGB - Texture' : png -o $work/convert.png $file"
    if has oiiotool; then
        time_of oiiotool-view "oiiotool $file --ch R,G,B --colorconfig $aces --ociodisplay:from='$from' '$display' '$view' \
            -d uint8 -o $work/oiiotool-view.png"
        time_of oiiotool-convert "oiiotool $file --ch R,G,B --colorconfig $aces --colorconvert '$from' 'sRGB - Texture' \
            -d uint8 -o $work/oiiotool-convert.png"
    fi
    if has ocioconvert; then
        time_of ocioconvert-view "OCIO=$aces ocioconvert --view $file '$from' $work/ocioconvert-view.png '$display' '$view'"
        time_of ocioconvert-convert "OCIO=$aces ocioconvert $file '$from' $work/ocioconvert-convert.png 'sRGB - Texture'"
    fi
    i=$((i + 1))
done
medians view oiiotool-view ocioconvert-view convert oiiotool-convert ocioconvert-convert
for what in view convert; do
    for peer in oiiotool ocioconvert; do
        ratio "$peer / hdr, $what" $peer-$what $what
        if [ -f "$work/$peer-$what.png" ] && has idiff; then
            idiff -fail 0 "$work/$what.png" "$work/$peer-$what.png" |
                awk -v name="$peer, $what" '/Max error/ {printf "%s: at most %.3g codes of 255 apart\n", name, $4 * 255}'
        fi
    done
done

#!/bin/sh
# durand.sh [FILE] [REPETITIONS]: the bilateral operator, EXR to PNG, beside pfstools, Luminance HDR (which stores its PNG
# uncompressed) and the filter alone in gmic, where they are installed. Interleaved repetitions, medians, ratios, and the
# peak memory of hdr.
. tests/bench/lib.sh
picture "${1:-}"

i=0
while [ "$i" -lt "${2:-3}" ]; do
    time_of clamp "$hdr clamp : png -o $work/c.png $file"
    time_of durand "$hdr durand : png -o $work/d.png $file"
    time_of durand-200M "$hdr durand : png --memory 200M -o $work/e.png $file"
    if has pfsinexr && has pfstmo_durand02 && has pfsoutimgmagick; then
        time_of pfstools "pfsinexr $file | pfstmo_durand02 | pfsgamma -g 2.2 | pfsoutimgmagick --bit-depth 8 $work/p.png"
    fi
    if has luminance-hdr-cli; then
        time_of luminance "QT_QPA_PLATFORM=offscreen luminance-hdr-cli -l $file --tmo durand --tmoDurSigmaS 40 \
            --tmoDurSigmaR 0.4 -o $work/l.png"
    fi
    if has gmic; then
        time_of gmic-filter "gmic $file bilateral 40,0.4 -o $work/g.png"
    fi
    i=$((i + 1))
done
cmp "$work/d.png" "$work/e.png"
medians clamp durand durand-200M pfstools luminance gmic-filter
for peer in pfstools luminance gmic-filter; do
    ratio "$peer / hdr" $peer durand
done
for options in '' '--memory 200M'; do
    # shellcheck disable=SC2086 # two words, or none
    peak=$( (command time -f '%M' "$hdr" durand : png $options -o "$work/m.png" "$file") 2>&1 | tail -n 1)
    echo "peak memory ${options:-as it comes}: $((peak / 1024)) MB"
done

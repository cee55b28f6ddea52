#!/bin/sh
# reinhard.sh [FILE] [REPETITIONS]: the photographic operator, EXR to PNG, beside pfstools and Luminance HDR where they are
# installed (Luminance HDR stores its PNG uncompressed). Interleaved repetitions, medians, ratios.
. tests/bench/lib.sh
picture "${1:-}"
gamma='pfsgamma -g 2.2 | pfsoutimgmagick --bit-depth 8'

i=0
while [ "$i" -lt "${2:-5}" ]; do
    time_of clamp "$hdr clamp : png -o $work/c.png $file"
    time_of global "$hdr reinhard : png -o $work/g.png $file"
    time_of estimate "$hdr reinhard --key estimate : png -o $work/e.png $file"
    time_of local "$hdr reinhard --local : png -o $work/l.png $file"
    if has pfsinexr && has pfstmo_reinhard02 && has pfsoutimgmagick; then
        time_of pfstools-global "pfsinexr $file | pfstmo_reinhard02 | $gamma $work/pg.png"
        time_of pfstools-local "pfsinexr $file | pfstmo_reinhard02 -s | $gamma $work/pl.png"
    fi
    if has luminance-hdr-cli; then
        luminance="QT_QPA_PLATFORM=offscreen luminance-hdr-cli -l $file --tmo reinhard02 --tmoR02Scales"
        time_of luminance-global "$luminance false -o $work/lg.png"
        time_of luminance-local "$luminance true -o $work/ll.png"
    fi
    i=$((i + 1))
done
medians clamp global estimate local pfstools-global pfstools-local luminance-global luminance-local
for kind in global local; do
    for peer in pfstools luminance; do
        ratio "$kind, $peer / hdr" "$peer-$kind" "$kind"
    done
done

#!/bin/sh
# pipe.sh [FILE] [REPETITIONS]: what a four-stage pipe costs beside one process, and what each costs beside oiiotool where it is installed.
# Interleaved repetitions, medians, ratios. FILE: a large EXR (by default one that oiiotool enlarges from testdata).
. tests/bench/lib.sh
picture "${1:-}"

i=0
while [ "$i" -lt "${2:-9}" ]; do
    time_of single "$hdr clamp : exp : srgb : png -o $work/a.png $file"
    time_of pipe "$hdr clamp $file | $hdr exp | $hdr srgb | $hdr png > $work/b.png"
    time_of clamp "$hdr clamp : png -o $work/c.png $file"
    if has oiiotool; then
        time_of oiiotool "oiiotool $file --ch R,G,B --colorconvert linear sRGB -d uint8 -o $work/d.png"
    fi
    i=$((i + 1))
done
cmp "$work/a.png" "$work/b.png"
medians single pipe clamp oiiotool
ratio 'pipe / single process' pipe single
ratio 'oiiotool / clamp to PNG' oiiotool clamp

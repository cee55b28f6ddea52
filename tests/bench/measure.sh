#!/bin/sh
# measure.sh [FILE] [REPETITIONS]: measuring a large picture against another one (error), beside idiff where it is
# installed, and what of it is inflating: the same pictures uncompressed; mean, diff and noise of several; FLIP and smooth of
# a part, the latter beside gmic's non-local means with windows and patches of the same size. Interleaved repetitions,
# medians, ratios.
. tests/bench/lib.sh
picture "${1:-}"
ln -s "$(realpath "$file")" "$work/a.exr"
"$hdr" expose --ev 0.01 : exr --type half -o "$work/b.exr" "$file"
for name in a b; do
    "$hdr" exr --type half --compression none -o "$work/$name-raw.exr" "$work/$name.exr"
    "$hdr" exr --type half --crop 100,100,960,540 -o "$work/$name-part.exr" "$work/$name.exr"
done
"$hdr" diff --kind absolute -o "$work/deviation.exr" "$work/a-part.exr" "$work/b-part.exr"

i=0
while [ "$i" -lt "${2:-5}" ]; do
    time_of error "$hdr error --against $work/a.exr $work/b.exr"
    time_of error-raw "$hdr error --against $work/a-raw.exr $work/b-raw.exr"
    time_of error-one-thread "$hdr error -j1 --against $work/a.exr $work/b.exr"
    time_of raw-one-thread "$hdr error -j1 --against $work/a-raw.exr $work/b-raw.exr"
    time_of mean "$hdr mean -o $work/m.exr $work/a.exr $work/b.exr $work/a.exr $work/b.exr"
    time_of diff "$hdr diff -o $work/d.exr $work/a.exr $work/b.exr"
    time_of noise "$hdr noise $work/a.exr $work/b.exr $work/a.exr $work/b.exr"
    time_of flip-part "$hdr error --flip hdr --against $work/a-part.exr $work/b-part.exr"
    time_of smooth-part "$hdr smooth --sigma-picture $work/deviation.exr -o $work/s.exr $work/a-part.exr"
    if has idiff; then time_of idiff "idiff -fail 1e30 -warn 1e30 $work/b.exr $work/a.exr"; fi
    if has gmic; then time_of gmic-part "gmic $work/a-part.exr denoise 10,10,7,21,0,0 -o $work/g.exr"; fi
    i=$((i + 1))
done
medians error error-raw error-one-thread raw-one-thread idiff mean diff noise flip-part smooth-part gmic-part
ratio 'idiff / error' idiff error
ratio 'uncompressed / error' error-raw error
ratio 'uncompressed / error, one thread' raw-one-thread error-one-thread
ratio 'gmic / smooth' gmic-part smooth-part

#!/bin/sh
# pipe.sh [FILE] [REPETITIONS]: what a four-stage pipe costs beside one process, and what each costs beside oiiotool where it is installed.
# Interleaved repetitions, medians, ratios. FILE: a large EXR (by default one that oiiotool enlarges from testdata).
set -eu
hdr=${BUILD:-build}/hdr
file=${1:-}
repetitions=${2:-9}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ -z "$file" ]; then
    file=$work/4k.exr
    oiiotool testdata/interior.exr --ch R,G,B --resize:filter=lanczos3 3840x2160 --clamp:min=0.00001:max=60000 \
        --pattern constant:color=1,1,1 3840x2160 3 --noise:type=gaussian:mean=0:stddev=0.02:seed=7 --mul \
        --clamp:min=0.00001:max=60000 --fullpixels -d half --compression zip --scanline -o "$file"
fi

now() { date +%s%N; }
# time_of NAME COMMAND: appends milliseconds to NAME's list
time_of() {
    start=$(now)
    sh -c "$2" >/dev/null 2>&1
    end=$(now)
    echo $(((end - start) / 10000)) >>"$work/$1.times"
}
median() { sort -n "$work/$1.times" | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)] / 100}'; }

i=0
while [ "$i" -lt "$repetitions" ]; do
    time_of single "$hdr clamp : exp : srgb : png -o $work/a.png $file"
    time_of pipe "$hdr clamp $file | $hdr exp | $hdr srgb | $hdr png > $work/b.png"
    time_of clamp "$hdr clamp : png -o $work/c.png $file"
    if command -v oiiotool >/dev/null; then
        time_of oiiotool "oiiotool $file --ch R,G,B --colorconvert linear sRGB -d uint8 -o $work/d.png"
    fi
    i=$((i + 1))
done
cmp "$work/a.png" "$work/b.png"
printf '%-10s %8s\n' what 'median ms'
for name in single pipe clamp oiiotool; do
    [ -f "$work/$name.times" ] && printf '%-10s %8s\n' $name "$(median $name)"
done
awk -v pipe="$(median pipe)" -v single="$(median single)" 'BEGIN {printf "pipe / single process: %.3f\n", pipe / single}'
if [ -f "$work/oiiotool.times" ]; then
    awk -v o="$(median oiiotool)" -v c="$(median clamp)" 'BEGIN {printf "oiiotool / clamp to PNG: %.1f\n", o / c}'
fi

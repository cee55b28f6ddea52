#!/bin/sh
# reinhard.sh FILE [REPETITIONS]: the photographic operator, EXR to PNG, beside pfstools and Luminance HDR where they are
# installed (Luminance HDR stores its PNG uncompressed). Interleaved repetitions, medians, ratios.
set -eu
hdr=${BUILD:-build}/hdr
file=${1:?the EXR to measure with}
repetitions=${2:-5}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

now() { date +%s%N; }
# time_of NAME COMMAND: appends hundredths of milliseconds to NAME's list
time_of() {
    start=$(now)
    sh -c "$2" >/dev/null 2>&1 || echo "$1: failed" >&2
    end=$(now)
    echo $(((end - start) / 10000)) >>"$work/$1.times"
}
median() { sort -n "$work/$1.times" | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)] / 100}'; }
has() { command -v "$1" >/dev/null; }

i=0
while [ "$i" -lt "$repetitions" ]; do
    time_of clamp "$hdr clamp : png -o $work/c.png $file"
    time_of global "$hdr reinhard : png -o $work/g.png $file"
    time_of estimate "$hdr reinhard --key estimate : png -o $work/e.png $file"
    time_of local "$hdr reinhard --local : png -o $work/l.png $file"
    if has pfsinexr && has pfstmo_reinhard02; then
        time_of pfstools-global "pfsinexr $file | pfstmo_reinhard02 | pfsgamma -g 2.2 | pfsoutimgmagick --bit-depth 8 $work/pg.png"
        time_of pfstools-local "pfsinexr $file | pfstmo_reinhard02 -s | pfsgamma -g 2.2 | pfsoutimgmagick --bit-depth 8 $work/pl.png"
    fi
    if has luminance-hdr-cli; then
        time_of luminance-global "QT_QPA_PLATFORM=offscreen luminance-hdr-cli -l $file --tmo reinhard02 --tmoR02Scales false -o $work/lg.png"
        time_of luminance-local "QT_QPA_PLATFORM=offscreen luminance-hdr-cli -l $file --tmo reinhard02 --tmoR02Scales true -o $work/ll.png"
    fi
    i=$((i + 1))
done
printf '%-18s %10s\n' what 'median ms'
for list in "$work"/*.times; do
    name=$(basename "$list" .times)
    printf '%-18s %10s\n' "$name" "$(median "$name")"
done
for kind in global local; do
    for peer in pfstools luminance; do
        [ -f "$work/$peer-$kind.times" ] || continue
        awk -v p="$(median "$peer-$kind")" -v h="$(median $kind)" -v k=$kind -v n=$peer \
            'BEGIN {printf "%s, %s / hdr: %.1f\n", k, n, p / h}'
    done
done

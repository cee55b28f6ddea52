# What the scripts of this folder share; they begin with `. tests/bench/lib.sh` and are run from the project's root.
# shellcheck shell=sh disable=SC2034 # the scripts use these variables, this file does not

set -eu
hdr=${BUILD:-build}/hdr
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

now() { date +%s%N; }

has() { command -v "$1" >/dev/null; }

# time_of NAME COMMAND: appends hundredths of milliseconds to NAME's list
time_of() {
    start=$(now)
    sh -c "$2" >/dev/null 2>&1 || echo "$1: failed" >&2
    end=$(now)
    echo $(((end - start) / 10000)) >>"$work/$1.times"
}

median() { sort -n "$work/$1.times" | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)] / 100}'; }

# medians NAME...: a line for each that was measured
medians() {
    printf '%-18s %10s\n' what 'median ms'
    for name in "$@"; do
        if [ -f "$work/$name.times" ]; then printf '%-18s %10s\n' "$name" "$(median "$name")"; fi
    done
}

# ratio TEXT A B: A's median in B's, if both were measured
ratio() {
    if [ -f "$work/$2.times" ] && [ -f "$work/$3.times" ]; then
        awk -v text="$1" -v a="$(median "$2")" -v b="$(median "$3")" 'BEGIN {printf "%s: %.3g\n", text, a / b}'
    fi
}

# a large picture of half floats that oiiotool enlarges from testdata, where no file is given
picture() {
    file=$1
    [ -z "$file" ] || return 0
    file=$work/4k.exr
    oiiotool testdata/interior.exr --ch R,G,B --resize:filter=lanczos3 3840x2160 --clamp:min=0.00001:max=60000 \
        --pattern constant:color=1,1,1 3840x2160 3 --noise:type=gaussian:mean=0:stddev=0.02:seed=7 --mul \
        --clamp:min=0.00001:max=60000 --fullpixels -d half --compression zip --scanline -o "$file"
}

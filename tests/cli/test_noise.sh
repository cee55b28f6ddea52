#!/bin/sh
# hdr noise on renders of the path tracer in testdata, which are independent with other seeds: what it tells without a
# reference, against one that took 512 times as many samples, and against many repetitions.
. tests/cli/lib.sh

render() { # SEED SAMPLES
    "$BUILD/testdata/render" interior --width 32 --height 24 --samples "$2" --seed "$1" --type float --compression zip \
        --threads 1 -o "$work/$1.exr"
}
seed=1
while [ "$seed" -le 320 ]; do
    render "$seed" 8 || break
    seed=$((seed + 1))
done
render 9999 4096
check 'renders are made' test -f "$work/320.exr" -a -f "$work/9999.exr"

# renders FROM TO: their names
renders() { seq -f "$work/%.0f.exr" "$1" "$2"; }

# number NAME: of the JSON in $work/stdout
number() { grep -o "\"$1\": [^,}]*" "$work/stdout" | head -n 1 | sed 's/.*: //'; }

# within A B E: A is no farther from B than E
within() { awk -v a="$1" -v b="$2" -v e="$3" 'BEGIN { exit !(a != "" && b != "" && e > 0 && (a - b) ^ 2 <= e ^ 2) }'; }

# ---- Against a reference -----------------------------------------------------------------------------------------

# shellcheck disable=SC2046 # words
expect_status 0 '64 renders' "$hdr" noise --json $(renders 1 64)
rmv=$(number rmv) error=$(number rmv_error)
check '64 renders: the error is a part of it' awk -v v="$rmv" -v e="$error" 'BEGIN { exit !(e > 0 && e < v / 4) }'
# shellcheck disable=SC2046 # words
rmse=$("$hdr" error --csv --against "$work/9999.exr" $(renders 1 64) |
    awk -F , 'NR > 1 { s += $4; n++ } END { printf "%.9g", sqrt(s / n) }')
check "RMV $rmv +- $error is the RMSE against a reference, $rmse" within "$rmv" "$rmse" "$(awk -v e="$error" 'BEGIN { print 2 * e }')"
grep -o '{"mean_of": [^}]*}' "$work/stdout" | sed 's/[^-0-9.e+ ]//g' >"$work/levels"
check 'six sizes of groups' test "$(wc -l <"$work/levels")" -eq 6
# shellcheck disable=SC2016 # awk's own
check 'it falls as the root of their number' awk -v v="$rmv" '
    { size = rmv = error = ""
      for (i = 1; i <= NF; i++) if ($i ~ /^[0-9]/) { if (size == "") size = $i; else if (rmv == "") rmv = $i; else error = $i }
      if (error != "" && (rmv - v / sqrt(size)) ^ 2 > (2 * error) ^ 2) bad = 1 }
    END { exit bad }' "$work/levels"

# the means of 16 renders, four of them, have a fourth of the noise
for part in 0 1 2 3; do
    # shellcheck disable=SC2046 # words
    "$hdr" mean -o "$work/mean$part.exr" $(renders $((16 * part + 1)) $((16 * part + 16)))
done
expect_status 0 'four means' "$hdr" noise --json "$work/mean0.exr" "$work/mean1.exr" "$work/mean2.exr" "$work/mean3.exr"
check 'RMV of means of 16 is a fourth' within "$(number rmv)" "$(awk -v v="$rmv" 'BEGIN { print v / 4 }')" \
    "$(awk -v e="$(number rmv_error)" 'BEGIN { print 2 * e }')"

# ---- The standard error against 20 repetitions -------------------------------------------------------------------

: >"$work/repetitions"
repetition=0
while [ "$repetition" -lt 20 ]; do
    # shellcheck disable=SC2046 # words
    "$hdr" noise --json $(renders $((16 * repetition + 1)) $((16 * repetition + 16))) >"$work/stdout"
    echo "$(number rmv) $(number rmv_error)" >>"$work/repetitions"
    repetition=$((repetition + 1))
done
# shellcheck disable=SC2016 # awk's own
check 'the jackknife tells the spread of 20 repetitions to a quarter' awk '
    { n++; d = $1 - mean; mean += d / n; squares += d * ($1 - mean); error += $2 }
    END { ratio = error / n / sqrt(squares / (n - 1)); exit !(ratio > 0.75 && ratio < 1.25) }' "$work/repetitions"

# ---- On the command line -----------------------------------------------------------------------------------------

expect_status 0 'two renders' "$hdr" noise "$work/1.exr" "$work/2.exr"
check 'two renders: no standard error' test "$(grep -c '+-' "$work/stdout")" -eq 1
# shellcheck disable=SC2046 # words
expect_status 0 'threads' "$hdr" noise --json -j1 $(renders 1 20)
cp "$work/stdout" "$work/one"
# shellcheck disable=SC2046 # words
expect_status 0 'threads' "$hdr" noise --json -j3 $(renders 1 20)
check 'threads change nothing' cmp -s "$work/one" "$work/stdout"
for cpu in c avx2; do
    # shellcheck disable=SC2046 # words
    HDR_CPU=$cpu "$hdr" noise --json $(renders 1 20) >"$work/stdout"
    check "HDR_CPU=$cpu changes nothing" cmp -s "$work/one" "$work/stdout"
done
# wide ones: tiles, of which some columns are held at a time; and less memory than a band of all would take
for seed in 1 2 3; do
    "$BUILD/testdata/render" interior --width 2600 --height 70 --samples 1 --seed "$seed" --type half --compression zip \
        --threads 1 -o "$work/wide$seed.exr"
done
wide='' tiled=''
i=0
while [ "$i" -lt 24 ]; do # of which three differ: as long as they are many, that is all the same
    wide="$wide $work/wide$((i % 3 + 1)).exr" tiled="$tiled $work/tiled$((i % 3 + 1)).exr"
    i=$((i + 1))
done
# shellcheck disable=SC2086 # words
expect_status 0 'wide' "$hdr" noise --json $wide
cp "$work/stdout" "$work/one"
rmv=$(number rmv) relative=$(number relative)
# shellcheck disable=SC2086 # words
expect_status 0 'little memory' "$hdr" noise --json --memory 1M $wide
check 'little memory changes nothing' cmp -s "$work/one" "$work/stdout"
if command -v exrmaketiled >/dev/null; then
    for seed in 1 2 3; do
        exrmaketiled -t 300 50 -z zip "$work/wide$seed.exr" "$work/tiled$seed.exr"
    done
    # shellcheck disable=SC2086 # words
    expect_status 0 'tiles' "$hdr" noise --json $tiled
    cp "$work/stdout" "$work/one"
    check 'tiles: rmv' within "$(number rmv)" "$rmv" "$(awk -v v="$rmv" 'BEGIN { print v * 1e-12 }')"
    check 'tiles: relative' within "$(number relative)" "$relative" "$(awk -v v="$relative" 'BEGIN { print v * 1e-12 }')"
    # shellcheck disable=SC2086 # words
    expect_status 0 'tiles, little memory' "$hdr" noise --json --memory 1M $tiled
    check 'tiles, little memory: nothing changes' cmp -s "$work/one" "$work/stdout"
else
    skip 'there is no exrmaketiled'
fi
# shellcheck disable=SC2046 # words
expect_status 0 'a target' "$hdr" noise --target 1 --json $(renders 1 20)
check 'a target: (rmv / target)^2 renders' test "$(number renders_for_target)" = \
    "$(awk -v v="$(number rmv)" 'BEGIN { n = v * v; printf "%d", n == int(n) ? n : int(n) + 1 }')"
# shellcheck disable=SC2046 # words
expect_status 0 'a sampling map' "$hdr" noise --sampling-map "$work/map.exr" $(renders 1 20)
# shellcheck disable=SC2046 # words
"$hdr" mean --show deviation : stats --json $(renders 1 20) >"$work/stdout"
deviation=$(number max_luminance)
"$hdr" stats --json "$work/map.exr" >"$work/stdout"
check 'a sampling map has one channel' test "$(number Y)" != ''
check 'a sampling map is largest where they differ most' awk -v m="$(number max_luminance)" -v d="$deviation" \
    'BEGIN { exit !(m > 2 && d > 0) }'
# shellcheck disable=SC2046 # words
expect_status 0 'a deviation map' "$hdr" noise --deviation-map "$work/deviation.exr" --sampling-map "$work/map2.exr" $(renders 1 20)
# shellcheck disable=SC2046 # words
"$hdr" mean --show deviation -o "$work/wanted.exr" $(renders 1 20)
check 'a deviation map is that of mean' cmp -s "$work/wanted.exr" "$work/deviation.exr"
check 'beside a sampling map' cmp -s "$work/map.exr" "$work/map2.exr"
"$hdr" info "$work/deviation.exr" >"$work/stdout"
check 'it tells what it is' grep -q 'hdrpipeMeaning (string) standard deviation of one of 20 renders$' "$work/stdout"
expect_status 64 'a deviation map on standard output' "$hdr" noise --deviation-map - "$work/1.exr" "$work/2.exr"
expect_status 64 'two maps in one file' "$hdr" noise --deviation-map "$work/y.exr" --sampling-map "$work/y.exr" "$work/1.exr" "$work/2.exr"
expect_status 73 'a deviation map that cannot be' "$hdr" noise --deviation-map "$work/none/x.exr" "$work/1.exr" "$work/2.exr"
expect_status 64 'one render' "$hdr" noise "$work/1.exr"
expect_status 64 'a map of one render' "$hdr" noise --sampling-map "$work/x.exr" "$work/1.exr"
check 'a map of one render: nothing is written' absent "$work/x.exr"
expect_status 64 'a chain in front' "$hdr" clamp : noise "$work/1.exr" "$work/2.exr"
expect_status 65 'other sizes' "$hdr" noise "$work/1.exr" testdata/interior.exr
expect_status 66 'a file is missing' "$hdr" noise "$work/1.exr" "$work/missing.exr"
expect_status 73 'a map that cannot be' "$hdr" noise --sampling-map "$work/none/x.exr" "$work/1.exr" "$work/2.exr"
expect_status 64 'a map on standard output' "$hdr" noise --sampling-map - "$work/1.exr" "$work/2.exr"
# ---- The plot ----------------------------------------------------------------------------------------------------

# read_plot FILE: what its marks, the ends of its bars and those of its line stand for, by the numbers at the axes alone:
# "mark SIZE RMV", "end SIZE RMV", "line SIZE RMV". What lies below the frame explains the signs.
read_plot() {
    # shellcheck disable=SC2016 # awk's own
    sed -n 's/^<text x="\([0-9.]*\)" y="488.0" text-anchor="middle">\([0-9.e+-]*\)<.*/x \1 \2/p
            s/^<text x="82.0" y="\([0-9.]*\)" text-anchor="end">\([0-9.e+-]*\)<.*/y \1 \2/p
            s/^<circle cx="\([0-9.]*\)" cy="\([0-9.]*\)" .*/mark \1 \2/p
            s/^<line x1="\([0-9.]*\)" y1="[0-9.]*" x2="\1" y2="\([0-9.]*\)" stroke="#0072b2".*/end \1 \2/p
            s/^<line x1="\([0-9.]*\)" y1="\([0-9.]*\)" x2="\([0-9.]*\)" y2="\([0-9.]*\)" stroke="#909090".*/line \1 \2\nline \3 \4/p' "$1" |
        awk '
            $1 == "x" { x[++xs] = $2; xv[xs] = log($3); next }
            $1 == "y" { y[++ys] = $2 - 4.5; yv[ys] = log($3); next }
            $3 < 470 { print $1, exp(xv[1] + ($2 - x[1]) * (xv[xs] - xv[1]) / (x[xs] - x[1])),
                exp(yv[1] + ($3 - y[1]) * (yv[ys] - yv[1]) / (y[ys] - y[1])) }'
}

# Each line of $work/wanted stands among what was read, to a hundredth; and there are as many of them.
as_wanted() {
    [ "$(wc -l <"$work/wanted")" -eq "$(wc -l <"$work/read")" ] || return 1
    # shellcheck disable=SC2016 # awk's own
    awk 'NR == FNR { kind[++n] = $1; size[n] = $2; rmv[n] = $3; next }
        { found = 0
          for (i = 1; i <= n; i++)
              if (kind[i] == $1 && (size[i] / $2 - 1) ^ 2 < 1e-4 && (rmv[i] / $3 - 1) ^ 2 < 1e-4) found = 1
          if (!found) exit 1 }' "$work/read" "$work/wanted"
}

for count in 40 5 3 2; do
    # shellcheck disable=SC2046 # words
    expect_status 0 "a plot of $count" "$hdr" noise --json --plot "$work/plot.svg" $(renders 1 "$count")
    # shellcheck disable=SC2046 # words
    "$hdr" noise --json $(renders 1 "$count") >"$work/json"
    check "a plot of $count: the same is printed" cmp -s "$work/json" "$work/stdout"
    check "a plot of $count: XML" well_formed "$work/plot.svg"
    read_plot "$work/plot.svg" >"$work/read"
    # shellcheck disable=SC2016 # awk's own
    sed 's/.*"convergence": \[//; s/}, /\n/g' "$work/json" | sed 's/[^0-9.e+ n-]//g; s/[a-df-z]//g' |
        awk '{ size = rmv = error = ""
               for (i = 1; i <= NF; i++) if ($i ~ /^[0-9]/) { if (size == "") size = $i; else if (rmv == "") rmv = $i; else error = $i }
               if (NR == 1) { first = rmv; print "line 1", rmv }
               print "mark", size, rmv
               if (error != "") { print "end", size, rmv + error; print "end", size, rmv - error < rmv / 10 ? rmv / 10 : rmv - error }
               last = size }
             END { print "line", last, first / sqrt(last) }' >"$work/wanted"
    check "a plot of $count: its marks are the numbers" as_wanted
done
expect_status 0 'a plot of no noise' "$hdr" noise --plot "$work/plot.svg" "$work/1.exr" "$work/1.exr"
check 'a plot of no noise: XML' well_formed "$work/plot.svg"
check 'a plot of no noise: no mark' test -z "$(read_plot "$work/plot.svg")"
check 'a plot of no noise: it says so' grep -q 'figures of 0' "$work/plot.svg"
expect_status 64 'a plot that is no SVG' "$hdr" noise --plot "$work/x.png" "$work/1.exr" "$work/2.exr"
expect_status 73 'a plot that cannot be' "$hdr" noise --plot "$work/none/x.svg" "$work/1.exr" "$work/2.exr"
expect_status 65 'a plot of other sizes' "$hdr" noise --plot "$work/x.svg" "$work/1.exr" testdata/interior.exr
check 'a plot of other sizes: nothing is written' absent "$work/x.svg"
# the same render twice has no noise
expect_status 0 'one render twice' "$hdr" noise --json "$work/1.exr" "$work/1.exr"
check 'one render twice: no noise' test "$(number rmv)" = 0

finish test_noise

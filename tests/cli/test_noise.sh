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
expect_status 64 'one render' "$hdr" noise "$work/1.exr"
expect_status 64 'a map of one render' "$hdr" noise --sampling-map "$work/x.exr" "$work/1.exr"
check 'a map of one render: nothing is written' absent "$work/x.exr"
expect_status 64 'a chain in front' "$hdr" clamp : noise "$work/1.exr" "$work/2.exr"
expect_status 65 'other sizes' "$hdr" noise "$work/1.exr" testdata/interior.exr
expect_status 66 'a file is missing' "$hdr" noise "$work/1.exr" "$work/missing.exr"
expect_status 73 'a map that cannot be' "$hdr" noise --sampling-map "$work/none/x.exr" "$work/1.exr" "$work/2.exr"
expect_status 64 'a map on standard output' "$hdr" noise --sampling-map - "$work/1.exr" "$work/2.exr"
# the same render twice has no noise
expect_status 0 'one render twice' "$hdr" noise --json "$work/1.exr" "$work/1.exr"
check 'one render twice: no noise' test "$(number rmv)" = 0

finish test_noise

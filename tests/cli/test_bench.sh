#!/bin/sh
# hdr bench: what it prints is well-formed and consistent, errors keep the bounds, wrong words are refused. No time is judged.
. tests/cli/lib.sh

picture=testdata/glossy.exr
# little enough for the exact method
small='--sigma-s 2px --crop 60,40,96,64'

# ---- CSV ---------------------------------------------------------------------------------------------------------

header=method,option,value,automatic,inferred,repetitions,whole_ms,own_ms,max_error,rms_error,bound,pixels_off_percent,largest_code_difference

# csv FILE: the lines of ways, of which each is sound; what is not is told.
unsound() {
    awk -F , 'NR > 1 {
        if (NF != 13) print NR ": " NF " fields"
        if ($4 !~ /^[01]$/ || $5 !~ /^[01]$/ || $6 !~ /^[0-9]+$/ || $6 < 1) print NR ": flags"
        for (i = 7; i <= 13; i++)
            if ($i != "" && $i !~ /^[0-9]+(\.[0-9]+)?(e[-+][0-9]+)?$/) print NR ": no number: " $i
        if ($7 == "" || $9 == "" || $10 == "") print NR ": something is missing"
        if ($10 + 0 > $9 + 0) print NR ": the mean is above the largest"
        if ($11 != "" && $9 + 0 > $11 + 0) print NR ": error " $9 " beyond " $11
        if ($1 == "exact" && !($9 == 0 && $10 == 0 && $11 == 0)) print NR ": the exact method is not exact"
        if (($1 == "exact" || $1 == "reference") && $12 != "" && $12 + $13 != 0) print NR ": codes of the best way"
        if (($12 == "") != ($13 == "")) print NR ": half of the codes"
    }' "$1"
}

# check_csv NAME: what the last command printed.
check_csv() {
    check "$1: header" test "$(head -n 1 "$work/stdout")" = "$header"
    faults=$(unsound "$work/stdout")
    check "$1: $faults" test -z "$faults"
}

ways() {
    awk -F , -v method="$1" '$1 == method' "$work/stdout" | wc -l
}

for scene in ramp one constant wide primaries alpha foreign window grey specials; do
    expect_status 0 "durand on $scene" "$hdr" bench -q --csv --repetitions 1 durand "testdata/tiny/$scene.exr"
    check_csv "durand on $scene"
    check "durand on $scene: grids" test "$(ways grid)" -ge 4
    check "durand on $scene: exact" test "$(ways exact)" -eq 1
done
# shellcheck disable=SC2086 # they are several words
expect_status 0 'durand' "$hdr" bench --csv --repetitions 2 durand $small $picture
check_csv 'durand'
check 'durand: all cells' test "$(awk -F , '$1 == "grid" { print $3 }' "$work/stdout" | sort -u | wc -l)" -eq "$(ways grid)"
check 'durand: one way is the automatic one' test "$(awk -F , '$4 == 1' "$work/stdout" | wc -l)" -eq 1
check 'durand: codes are compared' test "$(awk -F , 'NR > 1 && $12 == ""' "$work/stdout" | wc -l)" -eq 0
coarse_is_wrong() { awk -F , '$1 == "grid" && $3 == "2x2" && $9 > 1e-6 { found = 1 } END { exit !found }' "$work/stdout"; }
check 'durand: a coarse grid is not exact' coarse_is_wrong
cp "$work/stdout" "$work/durand.csv"

# the same pixels each time, and through a pipe
errors() { cut -d , -f 1-3,9-13 "$1"; }
errors "$work/durand.csv" >"$work/errors"
from_pipe() { "$hdr" expose --ev 0 <$picture | "$hdr-bench" --csv --repetitions 1 -j1 durand --sigma-s 2px --crop=60,40,96,64; }
ln -s "$hdr" "$work/hdr"
ln -s hdr "$work/hdr-bench"
hdr_built=$hdr
hdr=$work/hdr
expect_status 0 'from a pipe' from_pipe
hdr=$hdr_built
errors "$work/stdout" >"$work/errors_of_pipe"
check 'from a pipe: the same errors' cmp -s "$work/errors" "$work/errors_of_pipe"

# what is marked as automatic is what is taken
# shellcheck disable=SC2046 # words
set -- $(awk -F , '$4 == 1 { print $1, $2, $3 }' "$work/durand.csv")
# shellcheck disable=SC2086
"$hdr" durand --method "$@" $small : png -o "$work/way.png" $picture
# shellcheck disable=SC2086
"$hdr" durand $small : png -o "$work/auto.png" $picture
check "automatic: $*" cmp -s "$work/way.png" "$work/auto.png"

# all pixels, or few; too little time for the exact method
# shellcheck disable=SC2086
expect_status 0 'all pixels' "$hdr" bench --csv --repetitions 1 --samples all durand $small $picture
check_csv 'all pixels'
cp "$work/stdout" "$work/all.csv"
no_smaller() { awk -F , 'NR == FNR { error[$1 $3] = $9; next } $9 + 0 < error[$1 $3] + 0 { exit 1 }' "$1" "$2"; }
check 'all pixels: no smaller error than at some' no_smaller "$work/durand.csv" "$work/all.csv"
# shellcheck disable=SC2086
expect_status 0 'no time' "$hdr" bench --csv --repetitions 1 --samples 50 --limit 0 durand $small $picture
check_csv 'no time'
check 'no time: exact is inferred' grep -q '^exact,,,0,1,1,' "$work/stdout"
check 'no time: the dearer settings are left out' stderr_has 'hdr: bench: grid 2x4 is left out: a cheaper one'
check 'no time: the cheapest is there' test "$(ways grid)" -eq 1
check 'no time: no codes' test "$(awk -F , 'NR > 1 && $12 != ""' "$work/stdout" | wc -l)" -eq 0
# shellcheck disable=SC2086
expect_status 0 'no time, as a table' "$hdr" bench --repetitions 1 --samples 50 --limit 0 durand $small $picture
check 'no time: that is said' grep -q 'codes are not compared: --method exact would take' "$work/stdout"
check 'no time: what is inferred is marked' grep -qE '^  exact .* ~[0-9]' "$work/stdout"

# ---- Any chain ---------------------------------------------------------------------------------------------------

near_reference() { awk -F , '$1 == "fast" { exit !($9 < 1e-5 && $13 <= 1) }' "$work/stdout"; }
for chain in expose 'expose --ev 2 : log : srgb' 'reinhard --local' 'log : png --bits 16' 'srgb : quantise --bits 5' png exr; do
    # shellcheck disable=SC2086
    expect_status 0 "$chain" "$hdr" bench --csv --repetitions 1 $chain $picture
    check_csv "$chain"
    check "$chain: two ways" test "$(ways fast) $(ways reference)" = '1 1'
    check "$chain: near the reference" near_reference
    check "$chain: no method, no bound" test -z "$(awk -F , 'NR > 1 { printf "%s", $2 $3 $8 $11 }' "$work/stdout")"
done
expect_status 0 'nothing is lit' "$hdr" bench --csv --repetitions 1 durand testdata/tiny/black.exr
check 'nothing is lit: there is nothing to vary' test "$(ways fast)" -eq 1
expect_status 0 'the last verb with methods' "$hdr" bench --json --repetitions 1 durand --sigma-s 1px : durand --sigma-s 1px testdata/tiny/ramp.exr
check 'the last verb with methods' grep -qF '"chain": "durand --sigma-s 1px then durand --sigma-s 1px"' "$work/stdout"
expect_status 0 'special values' "$hdr" bench --repetitions 1 log testdata/tiny/specials.exr
check 'special values are counted, in one line' one_line_with '7 NaN'

# ---- JSON --------------------------------------------------------------------------------------------------------

# Values become "v": what is left is the bare structure.
json_structure() {
    sed -E 's/"([^"\\]|\\.)*"/"s"/g; s/-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?/v/g; s/true|false|null/v/g; s/"s": ("s"|v)/m/g' "$1" |
        sed -E ':again; s/\{m(, m)*\}/o/; t again; s/"s": \[o(, o)*\]/m/; t again'
}
odd='a"\b<&>'"'"'.exr'
cp $picture "$work/$odd"
# shellcheck disable=SC2086
expect_status 0 'JSON' "$hdr" bench --json --repetitions 1 durand $small "$work/$odd"
check 'JSON: one object in one line' test "$(json_structure "$work/stdout")" = o
check 'JSON: the file' grep -qF 'a\"\\b<&>'"'"'.exr", "width": 96, "height": 64' "$work/stdout"
check 'JSON: the ways' test "$(grep -o '"method": ' "$work/stdout" | wc -l)" -eq "$(($(wc -l <"$work/durand.csv") - 1))"
expect_status 0 'JSON of any chain' "$hdr" bench --json --repetitions 1 log $picture
check 'JSON of any chain: one object' test "$(json_structure "$work/stdout")" = o
check 'JSON of any chain: what is unknown' grep -qF '"bound": null' "$work/stdout"

# ---- The table ---------------------------------------------------------------------------------------------------

# shellcheck disable=SC2086
expect_status 0 'table' "$hdr" bench --repetitions 1 durand $small $picture
check 'table: the picture' test "$(head -n 1 "$work/stdout")" = $picture
check 'table: its size and the chain' grep -q '^  96 x 64; durand --sigma-s 2px --crop 60,40,96,64, to png$' "$work/stdout"
check 'table: aligned' test "$(awk '/^  method/ { on = 1 } /^$/ { on = 0 } on && !/^$/ { seen[length($0)] } { if (/^$/) blank++ } blank == 2 { exit } END { n = 0; for (l in seen) n++; print n }' "$work/stdout")" -eq 1
check 'table: the automatic way is marked' test "$(grep -c '^\* [a-z]' "$work/stdout")" -eq 1
check 'table: the mark is explained' grep -q '^  \* what --method auto takes$' "$work/stdout"
control=$(printf '\033[7m')
cp testdata/tiny/one.exr "$work/${control}a.exr"
expect_status 0 'an odd name' "$hdr" bench --repetitions 1 --plot "$work/odd.svg" log "$work/${control}a.exr"
check 'an odd name: no control characters' test -z "$(cat "$work/stdout" "$work/odd.svg" | tr -dc '\033')"

# ---- The plot ----------------------------------------------------------------------------------------------------

# shellcheck disable=SC2086
expect_status 0 'plot' "$hdr" bench --csv --repetitions 1 --plot "$work/a.svg" durand $small "$work/$odd"
check 'plot: the numbers are printed all the same' test "$(wc -l <"$work/stdout")" -eq "$(wc -l <"$work/durand.csv")"
check 'plot: XML' well_formed "$work/a.svg"
check 'plot: the name is escaped' grep -qF 'a&#34;\b&#60;&#38;&#62;&#39;.exr, 96 &#215; 64' "$work/a.svg"
check 'plot: a mark for each way' test "$(grep -c '<circle' "$work/a.svg")" -ge "$(ways grid)"
for label in 'grid 3x4' 'direct 0.001' exact milliseconds 'largest error of the base layer'; do
    check "plot: $label" grep -q ">[a-z, ]*$label" "$work/a.svg"
done
within_frame() { awk -F '"' '/<circle/ && ($2 < 92 || $2 > 876 || $4 < 92) { exit 1 }' "$1"; }
check 'plot: marks within the frame' within_frame "$work/a.svg"
for scene in one constant black ramp; do
    expect_status 0 "plot of $scene" "$hdr" bench --repetitions 1 --plot "$work/b.svg" durand "testdata/tiny/$scene.exr"
    check "plot of $scene: XML" well_formed "$work/b.svg"
    check "plot of $scene: finite" test -z "$(grep -iE '[^a-z](nan|inf)[^a-z]' "$work/b.svg")"
done
long=$(printf '%0200d' 0 | sed 's/0/\xc3\xa9/g' | cut -c 1-200).exr
cp testdata/tiny/one.exr "$work/$long"
expect_status 0 'plot of a long name' "$hdr" bench --repetitions 1 --plot "$work/b.svg" log "$work/$long"
check 'plot of a long name: XML' well_formed "$work/b.svg"

# ---- Refusals ----------------------------------------------------------------------------------------------------

mkdir "$work/out"
# refused STATUS NAME COMMAND...: one line, no output.
refused() {
    expect_status "$@"
    check "$2: one line" stderr_lines 1
    check "$2: nothing is printed" test ! -s "$work/stdout"
    check "$2: nothing is left" empty_directory "$work/out"
}
refused 64 'no chain' "$hdr" bench
refused 64 'a file and no chain' "$hdr" bench $picture
refused 64 'options and no chain' "$hdr" bench --csv
refused 64 'behind another' "$hdr" log : bench $picture
refused 64 'twice' "$hdr" bench bench log $picture
refused 64 'a then' "$hdr" bench : log $picture
refused 64 'an unknown option' "$hdr" bench --nonesuch log $picture
refused 64 'its option behind the verb' "$hdr" bench log --csv $picture
refused 64 'two files' "$hdr" bench log $picture $picture
refused 64 '-o' "$hdr" bench -o "$work/out/a.png" log $picture
refused 64 '-o behind the verb' "$hdr" bench log -o "$work/out/a.png" $picture
refused 64 'a program' "$hdr" bench stats $picture
refused 64 'a program at the end' "$hdr" bench log : stats $picture
refused 64 '--reference' "$hdr" bench log --reference $picture
refused 64 '--method' "$hdr" bench durand --method grid $picture
refused 64 '--tolerance' "$hdr" bench durand --tolerance 0.1 $picture
refused 64 '--cells' "$hdr" bench durand --cells auto $picture
refused 64 'two forms' "$hdr" bench --csv --json log $picture
refused 73 'a plot that cannot be' "$hdr" bench --plot "$work/none/a.svg" log $picture
refused 66 'no such file' "$hdr" bench --plot "$work/out/a.svg" durand "$work/none.exr"
refused 65 'no picture' "$hdr" bench --plot "$work/out/a.svg" durand tests/run.sh
refused 65 'encoded twice' "$hdr" bench --plot "$work/out/a.svg" srgb : srgb $picture
refused 65 '--strict' "$hdr" bench --plot "$work/out/a.svg" log --strict testdata/tiny/specials.exr
refused 65 'no such part' "$hdr" bench durand --part 7 $picture
for words in '--repetitions 0' '--repetitions many' '--samples 0' '--limit -1' '--plot a.png' '--plot .svg' '--plot b/.svg'; do
    # shellcheck disable=SC2086
    expect_status 64 "$words" "$hdr" bench $words log $picture
    check "$words: its help line" stderr_has "      ${words%% *} "
done

# ---- Help --------------------------------------------------------------------------------------------------------

expect_status 0 'help' "$hdr" help bench
check 'help: the grammar' test "$(head -n 1 "$work/stdout")" = 'usage: hdr bench [OPTION...] VERB [OPTION...] [then VERB [OPTION...]]... [FILE]'
cp "$work/stdout" "$work/help"
for words in 'bench --help' 'bench log -h' 'bench --help log'; do
    # shellcheck disable=SC2086
    expect_status 0 "$words" "$hdr" $words
    check "$words: the same help" cmp -s "$work/help" "$work/stdout"
done
check 'it is a program' test "$(verbs_of_kind program | grep -c '^bench$')" -eq 1

# ---- durand --cells ----------------------------------------------------------------------------------------------

for cells in 3 3x 3x4x x 1x4 3x17 3X4 ' 3x4' '3 x4' '-3x4' nan inf 3xinf ''; do
    expect_status 64 "--cells '$cells'" "$hdr" durand --method grid --cells "$cells" -o "$work/a.png" $picture
done
for cells in 2x2 16x2 2.5x4.25 auto; do
    expect_status 0 "--cells '$cells'" "$hdr" durand --method grid --sigma-s 8px --cells "$cells" : png -o "$work/a.png" $picture
done
for words in '--method exact --tolerance 0.1' '--method piecewise --tolerance 0.1' '--method exact --cells 3x4' \
    '--method grid --subsample 4' '--subsample 4'; do
    # shellcheck disable=SC2086 # words
    expect_status 64 "$words" "$hdr" durand $words -o "$work/a.png" $picture
    check "$words: it has no meaning" one_line_with 'has no meaning with --method'
done
expect_status 64 'no grid is small enough' "$hdr" durand --method grid --sigma-s 0.1px --sigma-r 0.01 -o "$work/a.png" testdata/interior.exr
check 'no grid is small enough: that is said' one_line_with 'too large'

# pixels to compare at are those that are lit, however few: two of a million
{ printf 'Pf\n1000 1000\n-1.0\n' && head -c 2000000 /dev/zero && printf '\000\000\200\077\000\000\200\100' && head -c 1999992 /dev/zero; } >"$work/few.pfm"
expect_status 0 'few are lit' "$hdr" bench --json --repetitions 1 --samples 50 --limit 0.1 durand "$work/few.pfm"
check 'few are lit: they are compared' grep -q '"random_pixels": 2,' "$work/stdout"
expect_status 0 'few are lit, as a table' "$hdr" bench --repetitions 1 --samples 50 --limit 0.1 durand "$work/few.pfm"
check 'few are lit: so it says' grep -q 'at all 2 lit pixels' "$work/stdout"
# what auto takes is among the ways, with settings that no list has; where nothing is computed, no way is marked
expect_status 0 'auto' "$hdr" bench --csv --repetitions 1 --samples 50 --limit 0.1 durand --sigma-r 3 --sigma-s 8px $picture
check 'one way is what auto takes' test "$(awk -F , 'NR > 1 && $4 == 1' "$work/stdout" | wc -l)" -eq 1
expect_status 0 'one intensity' "$hdr" bench --csv --repetitions 1 --samples 50 --limit 0.1 durand testdata/tiny/constant.exr
check 'one intensity: no way is marked' test "$(awk -F , 'NR > 1 && $4 == 1' "$work/stdout" | wc -l)" -eq 0
# a plot that cannot be written: what was measured is told all the same
ln -s /dev/full "$work/full.svg"
expect_status 74 'a full disk' "$hdr" bench --repetitions 1 --plot "$work/full.svg" log $picture
check 'a full disk: the table' grep -q 'reference' "$work/stdout"

expect_status 64 '--cells without grid' "$hdr" durand --cells 3x4 -o "$work/a.png" $picture
expect_status 64 '--cells and --tolerance' "$hdr" durand --method grid --cells 3x4 --tolerance 0.01 -o "$work/a.png" $picture
check '--cells and --tolerance: that is said' stderr_has '--tolerance has no meaning with --cells 3x4'

finish test_bench

#!/bin/sh
# The committed pictures are what their generators make: pixels are compared, since compressed bytes depend on the deflating library.
set -u
build=${BUILD:-build}
hdr=$build/hdr
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
passed=0 failed=0

# same_pixels COMMITTED MADE
same_pixels() {
    if "$hdr" exr --compression none --window data -q -o "$work/a.exr" "$1" &&
        "$hdr" exr --compression none --window data -q -o "$work/b.exr" "$2" && cmp "$work/a.exr" "$work/b.exr"; then
        passed=$((passed + 1))
    else
        echo "$1 is not what its generator makes" >&2
        failed=$((failed + 1))
    fi
}

mkdir "$work/tiny"
"$build/testdata/tiny" "$work/tiny" || failed=$((failed + 1))
for picture in testdata/tiny/*.exr; do same_pixels "$picture" "$work/tiny/$(basename "$picture")"; done

"$build/testdata/render" glossy --width 320 --height 240 --samples 64 --seed 1 --type half --compression piz -o "$work/glossy.exr" ||
    failed=$((failed + 1))
same_pixels testdata/glossy.exr "$work/glossy.exr"
printf 'test_testdata: %d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]

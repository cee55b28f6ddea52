# What the scripts of this folder share. They are run from the project's root and begin with `. tests/cli/lib.sh`.
# shellcheck shell=sh disable=SC2034 # the scripts use these variables, this file does not

BUILD=${BUILD:-build}
CC=${CC:-cc}
case $BUILD in
/*) ;;
*) BUILD=$PWD/$BUILD ;;
esac
hdr=$BUILD/hdr
# what is tested is the program, not the user's settings
unset HDR_THREADS HDR_CPU HDR_DEFER NO_COLOR SOURCE_DATE_EPOCH

work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

passed=0 failed=0 skipped=0

ok() {
    passed=$((passed + 1))
}

fail() {
    failed=$((failed + 1))
    printf 'failed: %s\n' "$*"
}

skip() {
    skipped=$((skipped + 1))
    printf 'skipped: %s\n' "$*"
}

# check NAME COMMAND...: the command succeeds.
check() {
    check_name=$1
    shift
    if "$@"; then ok; else fail "$check_name"; fi
}

# expect_status WANTED NAME COMMAND...: its exit status. What it wrote is in $work/stdout and $work/stderr afterwards.
expect_status() {
    wanted=$1 check_name=$2
    shift 2
    "$@" >"$work/stdout" 2>"$work/stderr"
    status=$?
    if [ "$status" -eq "$wanted" ]; then
        ok
    else
        fail "$check_name: status $status instead of $wanted, $(head -n 2 "$work/stderr")"
    fi
}

# The last command wrote that many lines to standard error.
stderr_lines() {
    [ "$(wc -l <"$work/stderr")" -eq "$1" ]
}

# One line that holds the text and does not say it twice.
one_line_with() {
    stderr_lines 1 && [ "$(grep -oF -- "$1" "$work/stderr" | wc -l)" -eq 1 ]
}

stderr_has() {
    grep -qF -- "$1" "$work/stderr"
}

absent() {
    ! [ -e "$1" ] && ! [ -L "$1" ]
}

empty_directory() {
    [ -z "$(ls -A "$1")" ]
}

# The names of the verbs of a kind: filter, format, program.
verbs_of_kind() {
    "$hdr" help --list | awk -F '\t' -v kind="$1" '$2 == kind { print $1 }'
}

# is_png FILE, is_exr FILE: by their first bytes.
is_png() {
    [ "$(head -c 8 "$1" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]
}

is_exr() {
    [ "$(head -c 4 "$1" | od -An -tx1 | tr -d ' \n')" = 762f3101 ]
}

# little NUMBER: four bytes for printf.
little() {
    printf '\\%03o\\%03o\\%03o\\%03o' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24 & 255))
}

# Compiles $work/measure FILE COMMAND...: it writes "KILOBYTES MILLISECONDS" into FILE, and ends as the command did.
compile_measure() {
    cat >"$work/measure.c" <<'END'
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
int main(int count, char **words) {
    struct timespec from, to;
    struct rusage usage;
    int status;
    (void)count;
    clock_gettime(CLOCK_MONOTONIC, &from);
    pid_t child = fork();
    if (child == 0) {
        execv(words[2], words + 2);
        _exit(127);
    }
    if (child < 0 || wait4(child, &status, 0, &usage) != child) return 126;
    clock_gettime(CLOCK_MONOTONIC, &to);
    FILE *file = fopen(words[1], "w");
    if (!file) return 126;
    fprintf(file, "%ld %ld\n", usage.ru_maxrss, (to.tv_sec - from.tv_sec) * 1000 + (to.tv_nsec - from.tv_nsec) / 1000000);
    if (fclose(file) != 0) return 126;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
END
    measured=yes
    # shellcheck disable=SC2086 # it may hold options
    $CC -std=c11 -D_DEFAULT_SOURCE -o "$work/measure" "$work/measure.c" || measured=
    check 'the measuring program compiles' test -n "$measured"
}

# finish NAME: the line that the test runner reads. As the last command it gives the script its status.
finish() {
    printf '%s: %d passed, %d failed' "$1" "$passed" "$failed"
    if [ "$skipped" -gt 0 ]; then printf ', %d skipped' "$skipped"; fi
    printf '\n'
    [ "$failed" -eq 0 ]
}

# well_formed FILE: as XML.
well_formed() {
    if command -v xmllint >/dev/null; then
        xmllint --noout "$1" 2>"$work/xml" && return
        return 1
    fi
    head -n 1 "$1" | grep -q '^<?xml version="1.0" encoding="UTF-8"?>$' &&
        [ "$(grep -o '<[a-z]' "$1" | wc -l)" -eq "$(grep -oE '</[a-z]|/>' "$1" | wc -l)" ] &&
        ! sed 's/&#[0-9]*;//g' "$1" | grep -q '&' && [ "$(tail -n 1 "$1")" = '</svg>' ]
}

# make_nan_pictures: of the small room room.pfm as it is, part.pfm whose top is NaN, and nan.pfm that is nothing else
make_nan_pictures() {
    { printf 'PF\n160 120\n-1.0\n' && yes "$(printf '\377\377\377\377')" | tr -d '\n' | head -c 230400; } >"$work/nan.pfm"
    "$hdr" pfm -q -o "$work/room.pfm" testdata/interior_float.exr
    { head -c -400 "$work/room.pfm" && tail -c 400 "$work/nan.pfm"; } >"$work/part.pfm"
}

#!/bin/sh
# make install: programs that run, pages that are found, a library that others can build with.
. tests/cli/lib.sh

# what the build was made with, so that make has nothing to build anew
sanitizers=$(sed -n 's/.*-fsanitize=\([^ ]*\).*/\1/p' "$BUILD/flags")
sanitize=${sanitizers:+-fsanitize=$sanitizers}
install_into() {
    make install NO_DEPS=1 BUILD="$BUILD" CC="$CC" SAN="$sanitizers" "$@" >"$work/log" 2>&1
}
# a strict mask of the one who installs must not lock others out
umask 077
staged=$work/staged
if ! install_into DESTDIR="$staged" PREFIX=/opt/hdrpipe; then
    fail "make install: $(tail -n 3 "$work/log")"
    finish test_install
    exit
fi
ok
root=$staged/opt/hdrpipe
check 'nothing outside of the prefix' test "$(find "$staged" -type f -o -type l | grep -vc "^$root/")" -eq 0
check 'everybody may read it' test -z "$(find "$staged" -type f ! -perm -444)"
check 'everybody may enter the folders' test -z "$(find "$root" -type d ! -perm -555)"
check 'everybody may run it' test -z "$(find "$root/bin" -type f ! -perm -555)"

# ---- Programs and pages ------------------------------------------------------------------------------------------

plug_in=$BUILD/plugin/hdrpipe-exr.so
if [ -e "$plug_in" ]; then
    check 'the plug-in is installed' cmp -s "$plug_in" "$root/lib/hdrpipe/hdrpipe-exr.so"
    expect_status 0 'it is found beside the programs' "$root/bin/hdr" exr --compression dwaa -o "$work/dwaa.exr" testdata/glossy.exr
else
    skip "there is no $plug_in"
fi
plug_in=$BUILD/plugin/hdrpipe-ocio.so
if [ -e "$plug_in" ]; then
    check 'that of OpenColorIO is installed' cmp -s "$plug_in" "$root/lib/hdrpipe/hdrpipe-ocio.so"
    expect_status 0 'it is found, too' "$root/bin/hdr" ocio --list
else
    skip "there is no $plug_in"
fi
expect_status 0 'hdr runs' "$root/bin/hdr" --version
check 'it is this hdr' cmp -s "$BUILD/hdr" "$root/bin/hdr"
version=$(sed 's/^hdrpipe //' "$work/stdout")
for verb in $("$hdr" help --list | cut -f 1); do
    check "hdr-$verb is a link that may be moved with hdr" test "$(readlink "$root/bin/hdr-$verb")" = hdr
    expect_status 0 "hdr-$verb runs" "$root/bin/hdr-$verb" --help
    check "hdr-$verb is $verb" grep -q "^usage: hdr $verb " "$work/stdout"
    check "hdr-$verb(1)" cmp -s "man/hdr-$verb.1" "$root/share/man/man1/hdr-$verb.1"
done
for page in hdr.1 hdrpipe.5 hdrpipe.7; do
    check "$page" cmp -s "man/$page" "$root/share/man/man${page##*.}/$page"
done
if command -v man >/dev/null && MANPATH=$root/share/man man -w hdr-log >"$work/stdout" 2>/dev/null; then
    check 'man finds a page' grep -q "^$root/share/man/man1/hdr-log" "$work/stdout"
fi
PATH=$root/bin:$PATH
in_a_pipe() { hdr-log <testdata/glossy.exr | hdr-srgb | hdr-png >"$work/pipe.png"; }
expect_status 0 'the programs in a pipe' in_a_pipe
"$hdr" log : srgb : png -o "$work/chain.png" testdata/glossy.exr
check 'they make the same picture' cmp -s "$work/chain.png" "$work/pipe.png"

# ---- The library -------------------------------------------------------------------------------------------------

# valid C and C++, with nothing but the installed header
cat >"$work/user.c" <<'END'
#include <hdrpipe.h>

#include <stdio.h>
#include <string.h>

int main(void) {
    static const float values[6] = {0, 0.25f, 0.5f, 1, 2, 4};
    static const char *const log_words[] = {"log", "--k", "2"};
    static const char *const png_words[] = {"png"};
    const float *planes[3] = {values, NULL, NULL};
    hdr_error error;
    memset(&error, 0, sizeof error);
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_add(chain, log_words, 3, &error);
    hdr_chain_add(chain, png_words, 1, &error);
    hdr_input *input = hdr_input_planes(3, 2, 1, planes, NULL, &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_status status = error.status ? error.status : hdr_chain_run(chain, input, output, NULL, &error);
    size_t size = 0;
    const void *bytes = status == HDR_OK ? hdr_output_bytes(output, &size) : NULL;
    if (status != HDR_OK) fprintf(stderr, "%s\n", error.message);
    printf("%s %d\n", HDRPIPE_VERSION, bytes && size > 60 && memcmp(bytes, "\211PNG", 4) == 0);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return (int)status;
}
END

pc=$root/lib/pkgconfig/hdrpipe.pc
check 'the pkg-config file tells the version' grep -qx "Version: $version" "$pc"
check 'it does not tell where it was staged' test "$(grep -c "$staged" "$pc")" -eq 0
# pkg-config is told where the staged tree's root is; what the file requires is in the system's own
flags_of() { PKG_CONFIG_PATH=$root/lib/pkgconfig pkg-config "$@" hdrpipe | sed "s|/opt/hdrpipe|$root|g"; }
if command -v pkg-config >/dev/null; then
    check 'pkg-config takes the file' flags_of --validate
    cflags=$(flags_of --cflags)
    libs=$(flags_of --libs)
else
    skip 'pkg-config is not there'
    cflags=-I$root/include
    libs="-L$root/lib -lhdrpipe -lOpenEXRCore -lpng -ldeflate -lisal -lz -lm -pthread"
fi

# builds COMPILER WORDS...: a program of the library's user, without a warning, and it runs
builds() {
    name=$1
    shift
    # shellcheck disable=SC2086 # words
    check "$name: compiles and links" "$@" -pedantic -Wall -Wextra -Werror $sanitize $cflags -o "$work/user" $libs
    expect_status 0 "$name: runs" "$work/user"
    check "$name: makes a PNG" test "$(cat "$work/stdout")" = "$version 1"
    rm -f "$work/user"
}
# shellcheck disable=SC2086 # CC may hold options
builds C11 $CC -std=c11 "$work/user.c"
cxx=${CXX:-c++}
if command -v "$cxx" >/dev/null; then
    builds C++11 "$cxx" -std=c++11 -x c++ "$work/user.c" -x none
else
    skip 'there is no C++ compiler'
fi
check 'the library defines no name but its own' test -z "$(nm -g --defined-only "$root/lib/libhdrpipe.a" 2>/dev/null | awk 'NF == 3 { print $3 }' | grep -vE '^(hdr_|__odr_asan|_?_?asan|__ubsan)')"

# ---- And away again ----------------------------------------------------------------------------------------------

make uninstall NO_DEPS=1 BUILD="$BUILD" CC="$CC" SAN="$sanitizers" DESTDIR="$staged" PREFIX=/opt/hdrpipe >"$work/log" 2>&1
check 'make uninstall leaves no file' test -z "$(find "$staged" -type f -o -type l)"

finish test_install

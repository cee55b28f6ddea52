# hdrpipe. `make demo` and `make check` are all the set-up there is: they install what is missing, build, and run.
#
#   make [all]   builds $(BUILD)/hdr and $(BUILD)/libhdrpipe.a
#   make demo    tone maps a picture of testdata to $(BUILD)/demo.png
#   make check   builds and runs all tests; the last line counts them
#   make bench   times it beside other tools [FILE=a large EXR]
#   make lint    formatting, warnings of gcc and clang, man pages, shell scripts
#   make install PREFIX=/usr/local DESTDIR=
#
# Variables: CC, CXX (for the plug-ins alone), BUILD (another directory builds out of tree), SAN=address,undefined, WERROR=1,
# NO_DEPS=1 (never installs), CFLAGS, CXXFLAGS and LDFLAGS (added to the project's own). Give PREFIX when building, too, if
# programs of your own are to use the library: they look for plug-ins there.

PREFIX ?= /usr/local
DESTDIR ?=
BUILD ?= build
CFLAGS ?= -O3 -g
CXXFLAGS ?= -O2 -g
WERROR ?=
SAN ?=
NO_DEPS ?=

# V=1 shows the commands
Q := $(if $(V),,@)

STANDARD := -std=c11 -D_GNU_SOURCE
# results must not depend on machine or compiler: no contraction to fused operations, ever
EXACT := -ffp-contract=off -fno-math-errno -fno-trapping-math
WARNINGS := -Wall -Wextra $(if $(WERROR),-Werror)
SANITIZE := $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer -fno-sanitize-recover=all)
ALL_CFLAGS = $(CFLAGS) $(STANDARD) $(EXACT) $(WARNINGS) $(SANITIZE) -pthread -Iinclude
OPENEXR_CFLAGS = $(shell pkg-config --cflags OpenEXR 2>/dev/null)
LIBS := -lOpenEXRCore -lpng -ldeflate -lisal -lz -lm
PACKAGES := pkg-config libopenexr-dev libpng-dev libdeflate-dev libisal-dev zlib1g-dev g++ libopencolorio-dev
LINT_PACKAGES := clang clang-format shellcheck cppcheck mandoc
CHECK_PACKAGES := libmpfr-dev mandoc pngcheck openexr

SOURCES := $(filter-out src/verb/skeleton.c,$(wildcard src/*/*.c))
OBJECTS := $(SOURCES:%.c=$(BUILD)/%.o)
COMMANDS := $(patsubst %.c,$(BUILD)/%.o,$(wildcard cmd/*.c))
LIBRARY := $(BUILD)/libhdrpipe.a
PROGRAM := $(BUILD)/hdr

comma := ,
# The plug-ins are the only C++. They are built where there are a compiler and the headers of their libraries.
ifeq ($(origin CXX),default)
CXX := $(if $(findstring clang,$(CC)),clang++,c++)
endif
OPENEXR_CXX_HEADER := $(wildcard $(shell pkg-config --variable=includedir OpenEXR 2>/dev/null)/OpenEXR/ImfHeader.h)
OCIO_HEADER := $(wildcard $(shell pkg-config --variable=includedir OpenColorIO 2>/dev/null)/OpenColorIO/OpenColorIO.h)
HAVE_CXX := $(shell command -v $(CXX))
PLUGINS := $(strip $(if $(HAVE_CXX),$(if $(OPENEXR_CXX_HEADER),$(BUILD)/plugin/hdrpipe-exr.so) \
    $(if $(OCIO_HEADER),$(BUILD)/plugin/hdrpipe-ocio.so)))
# clang's sanitizers only see exceptions where the program brings the C++ library along
LIBS += $(if $(and $(SAN),$(findstring clang,$(CC))),-Wl$(comma)--push-state$(comma)--no-as-needed -lstdc++ -Wl$(comma)--pop-state)
# vptr: its runtime is for C++ programs alone
ALL_CXXFLAGS = $(CXXFLAGS) -std=c++14 $(WARNINGS) $(SANITIZE) $(if $(SAN),-fno-sanitize=vptr) -pthread
OPENEXR_CXXFLAGS = $(patsubst -I%,-isystem %,$(OPENEXR_CFLAGS))
OPENEXR_CXX_LIBS = $(shell pkg-config --libs OpenEXR 2>/dev/null)
OCIO_CXXFLAGS = $(patsubst -I%,-isystem %,$(shell pkg-config --cflags OpenColorIO 2>/dev/null))
OCIO_LIBS = $(shell pkg-config --libs OpenColorIO 2>/dev/null)

VERBS := $(shell sed -n 's/^HDR_VERB(\(.*\))/\1/p' src/verb/verbs.def)

.PHONY: all deps check-deps demo check check-exhaustive lint lint-deps bench man install uninstall clean
.DELETE_ON_ERROR:

all: $(PROGRAM) $(PLUGINS)
	@$(if $(findstring exr.so,$(PLUGINS)),:,echo 'no C++ compiler, or no C++ headers of OpenEXR: built without DWAA and DWAB')
	@$(if $(findstring ocio.so,$(PLUGINS)),:,echo 'no C++ compiler, or no headers of OpenColorIO: built without the verbs ocio and crosscheck')

# ---- What is needed ----

# $(call install-missing,PACKAGES): nothing is installed, and no list fetched, where all are there.
define install-missing
@missing=; for p in $(1); do \
    dpkg-query -W -f '$${db:Status-Status}\n' "$$p" 2>/dev/null | grep -qx installed || missing="$$missing $$p"; done; \
if [ -n "$$missing" ] && [ -z "$(NO_DEPS)" ]; then \
    as_root=; [ "$$(id -u)" = 0 ] || as_root=sudo; \
    echo "installing:$$missing"; \
    $$as_root apt-get update -qq && \
    $$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$missing >/dev/null; fi
endef

deps:
	$(call install-missing,$(PACKAGES))

check-deps: deps
	$(call install-missing,$(CHECK_PACKAGES))

# ---- Building ----

# The flags are a prerequisite: other flags in the same directory build anew.
$(BUILD)/flags: FORCE
	@mkdir -p $(BUILD); echo '$(CC) $(ALL_CFLAGS) $(CXX) $(ALL_CXXFLAGS) $(LDFLAGS)' | cmp -s - $@ || \
	    echo '$(CC) $(ALL_CFLAGS) $(CXX) $(ALL_CXXFLAGS) $(LDFLAGS)' >$@
FORCE:

$(BUILD)/src/%.o: src/%.c $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CC $@'
	$(Q)$(CC) $(ALL_CFLAGS) $(OPENEXR_CFLAGS) -Isrc -MMD -MP -c $< -o $@

# the commands see the public header alone
$(BUILD)/cmd/%.o: cmd/%.c $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CC $@'
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c $< -o $@

$(LIBRARY): $(OBJECTS)
	@echo '  AR $@'
	@rm -f $@
	$(Q)$(AR) rcs $@ $^

$(PROGRAM): $(COMMANDS) $(LIBRARY)
	@echo '  LD $@'
	$(Q)$(CC) $(CFLAGS) $(SANITIZE) $(LDFLAGS) -pthread -o $@ $^ $(LIBS)

# where programs look for plug-ins that are not installed together with them
$(BUILD)/src/base/plugin.o: private ALL_CFLAGS += -DHDR_PLUGIN_FOLDER='"$(PREFIX)/lib/hdrpipe"'

$(BUILD)/plugin/hdrpipe-exr.so: src/plugin/exr_dwa.cc src/plugin/exr_dwa.h $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CXX $@'
	$(Q)$(CXX) $(ALL_CXXFLAGS) $(OPENEXR_CXXFLAGS) -fPIC -shared -fvisibility=hidden $(LDFLAGS) $< -o $@ $(OPENEXR_CXX_LIBS)

# the configuration that is built in, as a string
$(BUILD)/plugin/aces.ocio.h: src/plugin/aces.ocio Makefile
	@mkdir -p $(@D)
	$(Q){ echo 'const char built_in[] ='; sed 's/["\\]/\\&/g; s/.*/"&\\n"/' $<; echo ';'; } >$@

$(BUILD)/plugin/hdrpipe-ocio.so: src/plugin/ocio.cc $(BUILD)/plugin/aces.ocio.h src/plugin/ocio.h include/hdrpipe.h $(BUILD)/flags
	@echo '  CXX $@'
	$(Q)$(CXX) $(ALL_CXXFLAGS) $(OCIO_CXXFLAGS) -Iinclude -I$(BUILD)/plugin -fPIC -shared -fvisibility=hidden $(LDFLAGS) $< -o $@ $(OCIO_LIBS)

-include $(OBJECTS:.o=.d) $(COMMANDS:.o=.d)

# ---- Trying ----

demo: deps
	$(MAKE) all
	$(PROGRAM) expose --auto then log then png -o $(BUILD)/demo.png testdata/interior.exr
	@echo "wrote $(BUILD)/demo.png"

include tests/tests.mk

# ---- Manual: OPTIONS, EXAMPLES and the rest of a verb's page come from its table ----

man: $(PROGRAM)
	for v in $(VERBS); do $(PROGRAM) help --man $$v >man/hdr-$$v.1 || exit 1; done
	$(PROGRAM) help --man >man/hdr.1

# ---- Looking for faults without running ----

C_FILES = $(wildcard src/*/*.[ch] src/*/*.cc tests/*/*.cc cmd/*.[ch] include/*.h tests/*/*.[ch] testdata/*.[ch])

lint-deps: check-deps
	$(call install-missing,$(LINT_PACKAGES))

lint: lint-deps
	$(MAKE) lint-built

.PHONY: lint-built
lint-built:
	clang-format --dry-run --Werror $(C_FILES)
	shellcheck -s sh $(wildcard tests/*.sh tests/*/*.sh) .ci/run
	cd man && ! mandoc -Tlint -W style *.1 *.5 *.7 | grep .
	for f in include/hdrpipe.h; do $(CC) -std=c11 -pedantic -Wall -Wextra -Werror -fsyntax-only -x c $$f && \
	    $(CXX) -std=c++11 -pedantic -Wall -Wextra -Werror -fsyntax-only -x c++ $$f || exit 1; done
	cppcheck -q --std=c11 --error-exitcode=1 --inline-suppr --suppress=missingIncludeSystem -Iinclude -Isrc src cmd
	cppcheck -q --language=c++ --std=c++14 --error-exitcode=1 --inline-suppr --suppress=missingIncludeSystem \
	    $(wildcard src/*/*.cc tests/*/*.cc)

# ---- Installing ----

install: all
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/lib/pkgconfig $(DESTDIR)$(PREFIX)/include
	install -d $(DESTDIR)$(PREFIX)/share/man/man1 $(DESTDIR)$(PREFIX)/share/man/man5 $(DESTDIR)$(PREFIX)/share/man/man7
	install $(PROGRAM) $(DESTDIR)$(PREFIX)/bin/hdr
	for v in $(VERBS); do ln -sf hdr $(DESTDIR)$(PREFIX)/bin/hdr-$$v || exit 1; done
	install -m 644 $(LIBRARY) $(DESTDIR)$(PREFIX)/lib/
	install -m 644 include/hdrpipe.h $(DESTDIR)$(PREFIX)/include/
	install -m 644 man/*.1 $(DESTDIR)$(PREFIX)/share/man/man1/
	install -m 644 man/*.5 $(DESTDIR)$(PREFIX)/share/man/man5/
	install -m 644 man/*.7 $(DESTDIR)$(PREFIX)/share/man/man7/
	printf 'prefix=%s\nName: hdrpipe\nDescription: HDR renders to display pictures\nVersion: %s\nRequires: libpng OpenEXR\nLibs: -L$${prefix}/lib -lhdrpipe $(LIBS) -pthread\nCflags: -I$${prefix}/include\n' \
	    '$(PREFIX)' "$$(sed -n 's/.*HDRPIPE_VERSION "\(.*\)"/\1/p' include/hdrpipe.h)" >$(BUILD)/hdrpipe.pc
	$(if $(PLUGINS),install -d $(DESTDIR)$(PREFIX)/lib/hdrpipe && install -m 644 $(PLUGINS) $(DESTDIR)$(PREFIX)/lib/hdrpipe/)
	install -m 644 $(BUILD)/hdrpipe.pc $(DESTDIR)$(PREFIX)/lib/pkgconfig/

uninstall:
	rm -f $(DESTDIR)$(PREFIX)/bin/hdr $(VERBS:%=$(DESTDIR)$(PREFIX)/bin/hdr-%)
	rm -f $(DESTDIR)$(PREFIX)/lib/hdrpipe/hdrpipe-exr.so $(DESTDIR)$(PREFIX)/lib/hdrpipe/hdrpipe-ocio.so
	if [ -d $(DESTDIR)$(PREFIX)/lib/hdrpipe ]; then rmdir $(DESTDIR)$(PREFIX)/lib/hdrpipe; fi
	rm -f $(DESTDIR)$(PREFIX)/lib/libhdrpipe.a $(DESTDIR)$(PREFIX)/lib/pkgconfig/hdrpipe.pc $(DESTDIR)$(PREFIX)/include/hdrpipe.h
	rm -f $(patsubst man/%,$(DESTDIR)$(PREFIX)/share/man/man1/%,$(wildcard man/*.1))
	rm -f $(patsubst man/%,$(DESTDIR)$(PREFIX)/share/man/man5/%,$(wildcard man/*.5))
	rm -f $(patsubst man/%,$(DESTDIR)$(PREFIX)/share/man/man7/%,$(wildcard man/*.7))

clean:
	rm -rf $(BUILD)

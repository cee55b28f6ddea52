# Tests. Each is a program or a script that prints "name: N passed, M failed[, K skipped]" as its last line and fails if M > 0; tests/run.sh adds them
# up. C tests: tests/unit (against the library's rooms), tests/laws and tests/oracle (properties and independent evaluations).
# Scripts: tests/cli, tests/laws.

TEST_SOURCES := $(wildcard tests/unit/test_*.c tests/laws/test_*.c tests/oracle/test_*.c)
TEST_PROGRAMS := $(TEST_SOURCES:%.c=$(BUILD)/%)
# comparisons with C++ libraries, where there are a compiler and headers for them
CXX_TEST_SOURCES := $(wildcard tests/oracle/test_*.cc)
HAVE_CXX := $(shell $(CXX) $$(pkg-config --cflags OpenEXR) -include ImfRgbaFile.h -fsyntax-only -x c++ /dev/null 2>/dev/null && echo yes)
OCIO_TEST := $(BUILD)/tests/oracle/test_ocio
CXX_TEST_PROGRAMS = $(if $(HAVE_CXX),$(filter-out $(OCIO_TEST),$(CXX_TEST_SOURCES:%.cc=$(BUILD)/%))) \
    $(if $(findstring ocio.so,$(PLUGINS)),$(OCIO_TEST))
$(OCIO_TEST): LIBS += $(OCIO_LIBS)
$(OCIO_TEST): CXX_FLAGS += $(OCIO_CXXFLAGS)
TEST_SCRIPTS := $(wildcard tests/cli/test_*.sh tests/laws/test_*.sh)

$(BUILD)/tests/%: tests/%.c $(LIBRARY) $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CC $@'
	$(Q)$(CC) $(ALL_CFLAGS) $(OPENEXR_CFLAGS) -Isrc -Itests/unit -MMD -MP $< -o $@ $(LIBRARY) $(LIBS) -lmpfr -lgmp

CXX_FLAGS = $(CFLAGS) -std=c++17 -D_GNU_SOURCE -ffp-contract=off $(WARNINGS) $(SANITIZE) -pthread -Iinclude -Isrc -Itests/unit
$(BUILD)/tests/%: tests/%.cc $(LIBRARY) $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CXX $@'
	$(Q)$(CXX) $(CXX_FLAGS) $(OPENEXR_CFLAGS:-I%=-isystem %) -MMD -MP $< -o $@ $(LIBRARY) $$(pkg-config --libs OpenEXR) $(LIBS)

-include $(TEST_PROGRAMS:=.d) $(CXX_TEST_SOURCES:%.cc=$(BUILD)/%.d)

# the generators of testdata, built so that they stay in order
RENDER_SOURCES := testdata/render.c testdata/path.c testdata/scenes.c testdata/write_exr.c
$(BUILD)/testdata/render: $(RENDER_SOURCES) $(wildcard testdata/*.h) $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CC $@'
	$(Q)$(CC) $(ALL_CFLAGS) $(OPENEXR_CFLAGS) -o $@ $(RENDER_SOURCES) -lOpenEXRCore -lm
$(BUILD)/testdata/tiny: testdata/tiny.c testdata/write_exr.c testdata/write_exr.h $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CC $@'
	$(Q)$(CC) $(ALL_CFLAGS) $(OPENEXR_CFLAGS) -o $@ testdata/tiny.c testdata/write_exr.c -lOpenEXRCore -lm

# reads with OpenEXR's C++ library: where that is there
COMPARE_EXR := $(if $(HAVE_CXX),$(BUILD)/tests/oracle/compare_exr)
$(BUILD)/tests/oracle/compare_exr: tests/oracle/compare_exr.cc $(BUILD)/flags
	@mkdir -p $(@D)
	@echo '  CXX $@'
	$(Q)$(CXX) $(ALL_CXXFLAGS) $(OPENEXR_CXXFLAGS) $(LDFLAGS) $< -o $@ $(OPENEXR_CXX_LIBS)

# programs look for plug-ins beside themselves
$(BUILD)/tests/%/plugin: $(PLUGINS)
	@mkdir -p $(@D)
	$(Q)ln -sfn ../../plugin $@

check: check-deps
	$(MAKE) --no-print-directory check-built

.PHONY: check-built
check-built: all $(TEST_PROGRAMS) $(CXX_TEST_PROGRAMS) $(COMPARE_EXR) $(BUILD)/tests/unit/plugin $(BUILD)/tests/laws/plugin $(BUILD)/tests/oracle/plugin $(BUILD)/testdata/render $(BUILD)/testdata/tiny
	BUILD=$(BUILD) CC='$(CC)' sh tests/run.sh $(TEST_PROGRAMS) $(CXX_TEST_PROGRAMS) $(TEST_SCRIPTS)
# Timings belong here and not in tests. FILE: a large EXR to measure with; otherwise one is made by oiiotool.
bench: all $(BUILD)/tests/bench/scales
	BUILD=$(BUILD) sh tests/bench/pipe.sh $(FILE)
	BUILD=$(BUILD) sh tests/bench/reinhard.sh $(FILE)
	BUILD=$(BUILD) sh tests/bench/durand.sh $(FILE)
	BUILD=$(BUILD) sh tests/bench/ocio.sh $(FILE)
	BUILD=$(BUILD) sh tests/bench/measure.sh $(FILE)
	$(BUILD)/tests/bench/scales

# Run time against error, drawn for verbs that compute something around a pixel and for curves: build/error-*.svg. What
# smooth needs, renders with their deviation, is made first.
NOISY := $(BUILD)/noisy-1.exr $(BUILD)/noisy-2.exr $(BUILD)/noisy-3.exr $(BUILD)/noisy-4.exr
$(NOISY): $(BUILD)/noisy-%.exr: $(BUILD)/testdata/render
	$(Q)$< interior --width 160 --height 120 --samples 8 --seed $* --type float --compression zip -o $@

.PHONY: bench-error
bench-error: all $(NOISY)
	for f in interior glossy; do for v in durand 'reinhard --local' reinhard log srgb pq; do \
	    $(PROGRAM) bench --plot "$(BUILD)/error-$$f-$$(echo $$v | tr -d ' ').svg" $$v testdata/$$f.exr || exit 1; done; done
	$(PROGRAM) mean -o $(BUILD)/noisy.exr $(NOISY)
	$(PROGRAM) mean --show mean-deviation -o $(BUILD)/noisy-deviation.exr $(NOISY)
	$(PROGRAM) bench --plot $(BUILD)/error-noisy-smooth.svg smooth --sigma-picture $(BUILD)/noisy-deviation.exr $(BUILD)/noisy.exr

include tests/oracle/oracle.mk

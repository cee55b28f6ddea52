# The exhaustive comparison of encodings with MPFR: every float in [0,1]. Minutes, so not part of check.
# EXHAUSTIVE=... hands arguments on, e.g. EXHAUSTIVE='--bits 16 --from 100'.

.PHONY: check-exhaustive
check-exhaustive: $(BUILD)/tests/oracle/exhaustive_srgb
	$< $(EXHAUSTIVE)

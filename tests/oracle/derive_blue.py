#!/usr/bin/env python3
"""Makes src/kernel/blue.c: 64 x 64 ranks whose pixels of ranks below any limit are spread evenly and without order
(python3 standard library only).

Robert Ulichney, "The void-and-cluster method for dither array generation", SPIE 1913, 1993. Each set pixel spreads a
Gaussian over the tile, which is taken for periodic; a cluster is where the sum is largest, a void where it is smallest.

1. Random pixels, a tenth of all, are spread: the tightest cluster's pixel goes to the largest void until it would go
   back to where it was.
2. From there pixels are taken away, the tightest cluster first: they get the ranks downwards to 0.
3. From there again, pixels are added, the largest void first: they get the ranks upwards. The paper looks at the
   clusters of pixels not set from half of the tile on; as all Gaussians together are the same everywhere, the tightest
   of them is the largest void of those set, so that nothing changes.

The Gaussian is in whole numbers: sums are exact, so that the result is the same whatever the machine and the order.

Usage: python3 derive_blue.py >blue.c && clang-format -i blue.c
"""

import math

SIDE = 64
PIXELS = SIDE * SIDE
SIGMA = 1.9  # in pixels; the paper's 1.5 leaves more of low frequencies
UNIT = 2 ** 40


def gaussian():
    """The spread of one pixel at 0,0, by (row, column) of a periodic tile."""
    weight = []
    for row in range(SIDE):
        for column in range(SIDE):
            dy, dx = min(row, SIDE - row), min(column, SIDE - column)
            weight.append(round(UNIT * math.exp(-(dx * dx + dy * dy) / (2 * SIGMA * SIGMA))))
    return weight


# What is not 0: (row, column, weight)
NEAR = [(i // SIDE, i % SIDE, w) for i, w in enumerate(gaussian()) if w > 0]


class Tile:
    def __init__(self):
        self.is_set = [False] * PIXELS
        self.energy = [0] * PIXELS

    def copy(self):
        other = Tile()
        other.is_set, other.energy = self.is_set[:], self.energy[:]
        return other

    def put(self, pixel, value):
        self.is_set[pixel] = value
        row, column, sign = pixel // SIDE, pixel % SIDE, 1 if value else -1
        for dy, dx, weight in NEAR:
            self.energy[(row + dy) % SIDE * SIDE + (column + dx) % SIDE] += sign * weight

    def tightest_cluster(self):
        return max((i for i in range(PIXELS) if self.is_set[i]), key=lambda i: self.energy[i])

    def largest_void(self):
        return min((i for i in range(PIXELS) if not self.is_set[i]), key=lambda i: self.energy[i])


def random_pixels(count):
    """Knuth's linear congruential generator: Python's own might change."""
    state, chosen = 1, []
    while len(chosen) < count:
        state = (state * 6364136223846793005 + 1442695040888963407) % 2 ** 64
        pixel = (state >> 33) % PIXELS
        if pixel not in chosen:
            chosen.append(pixel)
    return chosen


def void_and_cluster():
    start = Tile()
    count = PIXELS // 10
    for pixel in random_pixels(count):
        start.put(pixel, True)
    while True:
        cluster = start.tightest_cluster()
        start.put(cluster, False)
        void = start.largest_void()
        start.put(void, True)
        if void == cluster:
            break
    ranks = [0] * PIXELS
    tile = start.copy()
    for rank in reversed(range(count)):
        pixel = tile.tightest_cluster()
        tile.put(pixel, False)
        ranks[pixel] = rank
    tile = start
    for rank in range(count, PIXELS):
        pixel = tile.largest_void()
        tile.put(pixel, True)
        ranks[pixel] = rank
    return ranks


print("/* Blue noise by the void-and-cluster method: printed by tests/oracle/derive_blue.py, which says how. */")
print('#include "kernel/dither.h"\n')
print("const uint16_t hdr_blue_ranks[HDR_DITHER_RANKS] = {")
ranks = void_and_cluster()
for first in range(0, PIXELS, 16):
    print("    " + ", ".join(str(r) for r in ranks[first:first + 16]) + ",")
print("};")

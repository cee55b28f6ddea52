#!/usr/bin/env python3
"""Prints the tables of src/picture/palette.c, as they stand there.

viridis, magma, inferno and plasma are Stefan van der Walt's and Nathaniel Smith's, who have waived all rights (CC0):
their numbers are taken from matplotlib. coolwarm is computed: Moreland, Diverging Color Maps for Scientific
Visualization, Advances in Visual Computing (LNCS 5876), 2009.
"""
import math

ENTRIES = 256
COOL, WARM = (59, 76, 192), (180, 4, 38)
RGB_TO_XYZ = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))
WHITE = (0.95047, 1.0, 1.08883)


def inverse(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return (
        ((e * i - f * h) / det, (c * h - b * i) / det, (b * f - c * e) / det),
        ((f * g - d * i) / det, (a * i - c * g) / det, (c * d - a * f) / det),
        ((d * h - e * g) / det, (b * g - a * h) / det, (a * e - b * d) / det),
    )


def times(m, v):
    return [sum(x * y for x, y in zip(row, v)) for row in m]


def to_msh(rgb):
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (x / 255 for x in rgb)]
    f = [t ** (1 / 3) if t > 0.008856 else 7.787 * t + 16 / 116 for t in
         (x / w for x, w in zip(times(RGB_TO_XYZ, linear), WHITE))]
    lightness, a, b = 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])
    m = math.sqrt(lightness**2 + a**2 + b**2)
    return m, math.acos(lightness / m), math.atan2(b, a)


def to_rgb(m, s, h):
    lightness, a, b = m * math.cos(s), m * math.sin(s) * math.cos(h), m * math.sin(s) * math.sin(h)
    fy = (lightness + 16) / 116
    xyz = [w * (t**3 if t**3 > 0.008856 else (t - 16 / 116) / 7.787) for t, w in zip((fy + a / 500, fy, fy - b / 200), WHITE)]
    linear = times(inverse(RGB_TO_XYZ), xyz)
    return [round(255 * (12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055)) for c in linear]


def spun_hue(saturated, m):
    ms, s, h = saturated
    if ms >= m:
        return h
    spin = s * math.sqrt(m**2 - ms**2) / (ms * math.sin(s))
    return h + spin if h > -math.pi / 3 else h - spin


def coolwarm(t):
    cool, warm = to_msh(COOL), to_msh(WARM)
    middle = max(cool[0], warm[0], 88)
    if t < 0.5:
        one, other, t = cool, (middle, 0, spun_hue(cool, middle)), 2 * t
    else:
        one, other, t = (middle, 0, spun_hue(warm, middle)), warm, 2 * t - 1
    return to_rgb(*((1 - t) * x + t * y for x, y in zip(one, other)))


def show(name, colours):
    print(f"    [HDR_PALETTE_{name.upper()}] = {{")
    for i in range(0, ENTRIES, 11):
        print("        " + " ".join("0x%02x%02x%02x," % tuple(c) for c in colours[i : i + 11]))
    print("    },")


if __name__ == "__main__":
    import matplotlib

    for name in ("viridis", "magma", "inferno", "plasma"):
        show(name, [[round(255 * c) for c in rgb] for rgb in matplotlib.colormaps[name].colors])
    show("coolwarm", [coolwarm(i / (ENTRIES - 1)) for i in range(ENTRIES)])

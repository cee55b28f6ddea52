#!/usr/bin/env python3
"""Derives every constant of src/kernel/real.h (python3 standard library only).

Each polynomial is a weighted minimax fit (Remez exchange in 60-digit decimals). Its coefficients are rounded to double
one after the other, lowest order first, and the remaining ones are fitted again after each rounding, so that the
rounding of a coefficient is absorbed by the later ones. The printed error is the one of the final, rounded polynomial.

Usage: python3 derive_real.py          prints the C constants and the approximation errors
"""

from decimal import Decimal, getcontext
from fractions import Fraction
import math

getcontext().prec = 60
LN2 = Decimal(2).ln()
GRID_POINTS = 1500


def to_decimal(value):
    """The exact value of a double."""
    ratio = Fraction(value)
    return Decimal(ratio.numerator) / Decimal(ratio.denominator)


def round_to_double(value):
    """Nearest double of a Decimal (Python's float() of a decimal string rounds correctly)."""
    return float(value)


def truncate_to_bits(value, bits):
    """The double which keeps the `bits` leading significant bits of a positive Decimal."""
    exponent = math.frexp(float(value))[1]
    unit = Decimal(2) ** (exponent - bits)
    return float((value / unit).to_integral_value(rounding="ROUND_FLOOR") * unit)


def evaluate(coefficients, x):
    total = Decimal(0)
    for coefficient in reversed(coefficients):
        total = total * x + coefficient
    return total


def solve(matrix, right):
    """Gaussian elimination with partial pivoting."""
    size = len(right)
    rows = [row[:] + [right[i]] for i, row in enumerate(matrix)]
    for column in range(size):
        pivot = max(range(column, size), key=lambda i: abs(rows[i][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        for i in range(column + 1, size):
            factor = rows[i][column] / rows[column][column]
            for j in range(column, size + 1):
                rows[i][j] -= factor * rows[column][j]
    solution = [Decimal(0)] * size
    for i in reversed(range(size)):
        partial = sum((rows[i][j] * solution[j] for j in range(i + 1, size)), Decimal(0))
        solution[i] = (rows[i][size] - partial) / rows[i][i]
    return solution


class Fit:
    """Polynomial of `count` coefficients close to `series`, the error being multiplied by `weight`."""

    def __init__(self, series, weight, low, high, count):
        self.count = count
        # Chebyshev-spaced grid: dense at the ends, where the extrema of the error crowd.
        self.grid = []
        for i in range(GRID_POINTS):
            position = Decimal(math.cos(math.pi * (GRID_POINTS - 1 - i) / (GRID_POINTS - 1)))
            x = (low + high) / 2 + (high - low) / 2 * position
            self.grid.append((x, series(x), weight(x)))

    def remez(self, fixed):
        """Best free coefficients behind the given fixed ones."""
        free = self.count - len(fixed)
        # With k coefficients fixed the basis x^k, x^(k+1), .. vanishes at 0 and, for odd k, changes sign there: it is
        # the error times sign(x)^k which alternates.
        points = []
        for x, value, weight in self.grid:
            flipped = -weight if x < 0 and len(fixed) % 2 else weight
            points.append((x, value - evaluate(fixed, x), flipped))
        usable = [i for i, point in enumerate(points) if point[0] != 0 and point[2] != 0]
        step = (len(usable) - 1) / free
        reference = [usable[round(i * step)] for i in range(free + 1)]
        solution = None
        for _ in range(40):
            matrix, right = [], []
            for sign, index in enumerate(reference):
                x, value, weight = points[index]
                power = x ** len(fixed) if fixed else Decimal(1)
                row = []
                for _unused in range(free):
                    row.append(weight * power)
                    power *= x
                row.append(Decimal(-1) ** sign)
                matrix.append(row)
                right.append(weight * value)
            solution = solve(matrix, right)
            leveled = abs(solution[-1])
            found = list(fixed) + solution[:-1]
            errors = [p[2] * (evaluate(found, g[0]) - g[1]) for p, g in zip(points, self.grid)]
            extrema = self.alternating_extrema(errors, free + 1)
            if extrema is None:
                break
            reference = extrema
            if max(abs(e) for e in errors) <= leveled * Decimal("1.001"):
                break
        return solution[:-1]

    @staticmethod
    def alternating_extrema(errors, wanted):
        """Index of the largest error of every run of equal sign, the weakest runs dropped until `wanted` are left."""
        runs = []
        for index, error in enumerate(errors):
            if error == 0:
                continue
            if runs and (errors[runs[-1]] > 0) == (error > 0):
                if abs(error) > abs(errors[runs[-1]]):
                    runs[-1] = index
            else:
                runs.append(index)
        while len(runs) > wanted:
            weakest = min(range(len(runs)), key=lambda i: abs(errors[runs[i]]))
            if weakest in (0, len(runs) - 1):
                runs.pop(weakest)
            elif len(runs) >= wanted + 2:
                # An inner run goes together with its weaker neighbour, so that the signs still alternate.
                before, after = abs(errors[runs[weakest - 1]]), abs(errors[runs[weakest + 1]])
                first = weakest - 1 if before < after else weakest
                del runs[first:first + 2]
            else:
                runs.pop(0 if abs(errors[runs[0]]) < abs(errors[runs[-1]]) else -1)
        return runs if len(runs) == wanted else None

    def errors(self, coefficients):
        return [weight * (evaluate(coefficients, x) - value) for x, value, weight in self.grid]

    def run(self, name, forced=()):
        """Rounds coefficient after coefficient; `forced` gives the first ones."""
        fixed = list(forced)
        while len(fixed) < self.count:
            fixed.append(to_decimal(round_to_double(self.remez(fixed)[0])))
        worst = max(abs(error) for error in self.errors(fixed))
        print(f"/* {name}: weighted error <= 2^{math.log2(float(worst)):.2f} */")
        for index, coefficient in enumerate(fixed):
            print(f"    c{index} = {float(coefficient).hex()}")


def power_series(term, count=40):
    """sum term(j) x^j; 40 terms leave less than 2^-130 for every |x| used here."""
    terms = [term(j) for j in range(count)]
    return lambda x: evaluate(terms, x)


def main():
    factorial = [Decimal(math.factorial(j)) for j in range(60)]

    print(f"ln2 hi (40 bits) = {truncate_to_bits(LN2, 40).hex()}")
    print(f"ln2 lo           = {round_to_double(LN2 - to_decimal(truncate_to_bits(LN2, 40))).hex()}")
    print(f"1/ln2            = {round_to_double(1 / LN2).hex()}")
    two_over_ln2 = 2 / LN2
    print(f"2/ln2 hi (26 b)  = {truncate_to_bits(two_over_ln2, 26).hex()}")
    print(f"2/ln2 lo         = {round_to_double(two_over_ln2 - to_decimal(truncate_to_bits(two_over_ln2, 26))).hex()}")
    log10_2 = LN2 / Decimal(10).ln()
    print(f"log10(2)         = {round_to_double(log10_2).hex()}")
    print(f"log10(2) hi (26) = {truncate_to_bits(log10_2, 26).hex()}")
    print(f"log10(2) lo      = {round_to_double(log10_2 - to_decimal(truncate_to_bits(log10_2, 26))).hex()}")
    # The ends of exp's range: the last double not above ln(DBL_MAX), the first not below ln(2^-1022).
    upper = to_decimal(math.ldexp(2.0 - math.ldexp(1.0, -52), 1023)).ln()
    end = round_to_double(upper)
    print(f"ln(DBL_MAX)      = {(end if to_decimal(end) <= upper else math.nextafter(end, 0.0)).hex()}")
    lower = -1022 * LN2
    end = round_to_double(lower)
    print(f"ln(2^-1022)      = {(end if to_decimal(end) >= lower else math.nextafter(end, 0.0)).hex()}")
    print(f"sqrt(1/2)        = {round_to_double(Decimal('0.5').sqrt()).hex()}")

    # m in [sqrt(1/2), sqrt(2)], s = (m - 1) / (m + 1), z = s^2 <= (3 - 2 sqrt 2)^2; one part in 10^12 beyond the end.
    z_max = (3 - 2 * Decimal(2).sqrt()) ** 2 * (1 + Decimal("1e-12"))
    # ln(m) = 2 s + s z P(z) with P = sum 2 z^j / (2 j + 3); the error relative to ln(m) >= 2 s is z dP / 2.
    Fit(power_series(lambda j: Decimal(2) / (2 * j + 3)), lambda z: z / 2, Decimal(0), z_max, 7).run("log")
    # log2(m) = 2/ln2 (s + s z sum z^j / (2 j + 3)); error relative to 2/ln2 s.
    series = power_series(lambda j: two_over_ln2 / (2 * j + 3))
    Fit(series, lambda z: z / two_over_ln2, Decimal(0), z_max, 7).run("log2")

    # exp(r) = 1 + (r + r^2 Q(r)); weight |r| gives the error relative to r, so that it
    # serves expm1(r) too (|expm1(r)| >= 0.84 |r|); relative to exp(r) it is |r| / exp(r) <= 0.5 times that.
    r_max = Decimal("0.34658")
    Fit(power_series(lambda j: 1 / factorial[j + 2]), abs, -r_max, r_max, 11).run("exp", (Decimal("0.5"),))
    # 2^r = 1 + (r ln2_rounded + r (ln2_rest + r c1 + r^2 c2 ..)).
    r_max = Decimal("0.5000001")
    ln2_rest = to_decimal(round_to_double(LN2 - to_decimal(round_to_double(LN2))))
    print(f"ln2 rest = {float(ln2_rest).hex()}")
    Fit(power_series(lambda j: LN2 ** (j + 1) / factorial[j + 1]), abs, -r_max, r_max, 11).run(
        "exp2", (to_decimal(round_to_double(LN2)) + ln2_rest,))


if __name__ == "__main__":
    main()

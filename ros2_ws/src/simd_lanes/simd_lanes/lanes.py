"""Sixteen 32-bit lanes as one value, in compiled code and in plain Python.

Inside a function compiled by Numba a `Lanes` is LLVM's ``<16 x float>`` and a `Mask` its ``<16 x
i1>``: one register of AVX-512, two of AVX2, four of SSE2 or NEON. Every operation is the one that
IEEE 754 defines, rounded once; nothing is contracted or reassociated, and a fused multiply-add
stands where `fma` is written and nowhere else. A kernel therefore gives the same bits on every
processor.

In plain Python (``NUMBA_DISABLE_JIT=1``) the same names work on NumPy arrays and give the same
bits, slowly: this module is that meaning, `compiled` the other one.

`Words`, ``<16 x i32>``, are the same for unsigned integers modulo 2**32, of which random numbers
are made.

A scalar is accepted wherever a `Lanes` or `Words` is and means that float32, or that integer
modulo 2**32, in each lane. Arithmetic between two scalars is done by Python or Numba, which differ
in width: keep it out of kernels.
"""

from dataclasses import dataclass

import numpy as np

LANES = 16
HALF = LANES // 2


def _values(x):
    return x.values if isinstance(x, Lanes) else np.float32(x)


class Lanes:
    """Sixteen float32 values; `values` is an array of shape (16,)."""

    __slots__ = ('values',)

    def __init__(self, values):
        self.values = np.broadcast_to(np.asarray(values, dtype=np.float32), (LANES,))

    def __add__(self, other):
        return Lanes(self.values + _values(other))

    def __sub__(self, other):
        return Lanes(self.values - _values(other))

    def __mul__(self, other):
        return Lanes(self.values * _values(other))

    def __truediv__(self, other):
        return Lanes(self.values / _values(other))

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other):
        return Lanes(_values(other) - self.values)

    def __rtruediv__(self, other):
        return Lanes(_values(other) / self.values)

    def __neg__(self):
        return Lanes(-self.values)

    def __lt__(self, other):
        return Mask(self.values < _values(other))

    def __le__(self, other):
        return Mask(self.values <= _values(other))

    def __gt__(self, other):
        return Mask(self.values > _values(other))

    def __ge__(self, other):
        return Mask(self.values >= _values(other))


def _integers(x):
    return x.values if isinstance(x, Words) else np.uint32(x & 0xFFFFFFFF)


class Words:
    """Sixteen unsigned integers modulo 2**32; `values` is a uint32 array of shape (16,)."""

    __slots__ = ('values',)

    def __init__(self, values):
        self.values = np.asarray(values, dtype=np.uint32)

    def __add__(self, other):
        return Words(self.values + _integers(other))

    def __mul__(self, other):
        return Words(self.values * _integers(other))

    def __xor__(self, other):
        return Words(self.values ^ _integers(other))

    def __and__(self, other):
        return Words(self.values & _integers(other))

    def __or__(self, other):
        return Words(self.values | _integers(other))

    def __lshift__(self, places):
        return Words(self.values << np.uint32(places))

    def __rshift__(self, places):
        return Words(self.values >> np.uint32(places))


@dataclass(frozen=True)
class ByteTable:
    """What `look_up` puts in the place of bytes: 16 integers, 0 to 255."""

    values: tuple[int, ...]


@dataclass(frozen=True)
class ByteWeights:
    """What `weigh` sums: four integers, of the lowest byte first, and what is added to them.

    The magnitudes of the first two, and those of the last two, sum to 128 at most.
    """

    values: tuple[int, int, int, int]
    offset: int


class Mask:
    """Sixteen truth values, what comparing `Lanes` gives; `values` is an array of shape (16,)."""

    __slots__ = ('values',)

    def __init__(self, values):
        self.values = np.asarray(values, dtype=np.bool_)

    def __and__(self, other):
        return Mask(self.values & other.values)

    def __or__(self, other):
        return Mask(self.values | other.values)

    def __invert__(self):
        return Mask(~self.values)


def aligned_rows(count, dtype=np.float32):
    """Return zeros of 32 bits, shape (count, 16), each row on a cache line of its own."""
    memory = np.zeros(count * LANES + LANES, dtype=dtype)
    start = (-memory.ctypes.data // memory.itemsize) % LANES
    return memory[start : start + count * LANES].reshape(count, LANES)


def load(rows, row):
    """Return a row of a C-contiguous array of shape (n, 16), bounds unchecked.

    It is a `Lanes` where the array is of float32, `Words` where it is of uint32.
    """
    return (Words if rows.dtype == np.uint32 else Lanes)(rows[row].copy())


def store(rows, row, value):
    """Write a row of a C-contiguous array of shape (n, 16), bounds unchecked.

    The array is of float32 for a `Lanes` and of uint32 for `Words`.
    """
    rows[row] = value.values


def splat(scalar):
    """Return that scalar, rounded to float32, in every lane."""
    return Lanes(scalar)


def fma(a, b, c):
    """Return a * b + c, rounded once.

    The product of two float32 is exact in float64. Their sum with `c` is rounded to odd there,
    which makes the second rounding, to float32, the only one that counts (Boldo & Melquiond 2008).
    """
    product = np.float64(_values(a)) * np.float64(_values(b))
    addend = np.float64(_values(c))
    total = product + addend
    part = total - product
    error = (product - (total - part)) + (addend - part)
    even = (np.asarray(total).view(np.int64) & 1) == 0
    inexact = np.isfinite(total) & (error != 0) & even
    toward = np.where(error > 0, np.inf, -np.inf)
    return Lanes(np.where(inexact, np.nextafter(total, toward), total))


def minimum(a, b):
    """Return a where a < b, else b."""
    return select(Lanes(_values(a)) < b, a, b)


def maximum(a, b):
    """Return a where a > b, else b."""
    return select(Lanes(_values(a)) > b, a, b)


def absolute(a):
    """Return the absolute value."""
    return Lanes(np.abs(a.values))


def square_root(a):
    """Return the square root, rounded once; NaN below zero."""
    with np.errstate(invalid='ignore'):
        return Lanes(np.sqrt(a.values))


def copy_sign(magnitude, sign):
    """Return the magnitude of the one with the sign of the other."""
    return Lanes(np.copysign(_values(magnitude), _values(sign)))


def select(mask, a, b):
    """Return a where the mask is true, else b."""
    return Lanes(np.where(mask.values, _values(a), _values(b)))


def swap_halves(a):
    """Return lanes 8..15, then lanes 0..7."""
    return Lanes(np.roll(a.values, HALF))


def any_lane(mask):
    """Return whether the mask is true in some lane."""
    return bool(mask.values.any())


def lane_bits(mask):
    """Return the mask as an integer, lane i as bit i."""
    return int(np.packbits(mask.values, bitorder='little').view(np.uint16)[0])


def from_bits(words):
    """Return the float32 that have these bit patterns."""
    return Lanes(words.values.view(np.float32))


def signed(words):
    """Return the words as signed integers, -2**31 to 2**31 - 1, rounded to float32."""
    return Lanes(words.values.view(np.int32))


def look_up(table, words):
    """Return the words with each byte, 0 to 15, replaced by that value of a `ByteTable`."""
    replaced = np.array(table.values, np.uint8)[words.values.view(np.uint8)]
    return Words(replaced.view(np.uint32))


def weigh(weights, words):
    """Return the sum of each word's bytes, times their `ByteWeights`, and the offset."""
    weighted = words.values.view(np.uint8).reshape(LANES, 4) @ np.array(weights.values)
    return Words((weighted + weights.offset).astype(np.uint32))


def subtract_bits(constant, a):
    """Return the float32 whose bit pattern is `constant` less that of `a`.

    The starting point of Newton's method for 1/a.
    """
    return Lanes((np.uint32(constant) - a.values.view(np.uint32)).view(np.float32))


def add_exponent(a, n):
    """Return a * 2**k, where the lowest bits of the bit pattern of `n` hold the integer k.

    ``n = 1.5 * 2**23 + k`` has that form. Neither argument nor result may be subnormal or
    overflow.
    """
    return Lanes(
        (a.values.view(np.uint32) + (n.values.view(np.uint32) << np.uint32(23))).view(np.float32)
    )

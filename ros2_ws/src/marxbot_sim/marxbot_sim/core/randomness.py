"""Random numbers by counter: a function of a key and a number, with no state to keep in order.

Two generators. SplitMix64 (Steele, Lea & Flood 2014) gives the few numbers of an episode: it steps
a counter by a constant and mixes its bits. What is drawn in every tick comes from 32-bit lanes,
for 16 robots at once: a key and the tick are mixed to two words, and each number of the tick mixes
these two once more, by multiplications and shifts (the constants are of Wellons, hash-prospector).
A number makes eight normal values, see `eight_normals`.
The numbers of an episode thus depend on its key and the tick alone: not on the lane, the thread or
the order in which episodes are played.
"""

import math

import numba
import numpy as np

from simd_lanes import ByteTable, ByteWeights, from_bits, look_up, signed, weigh

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)

_WORD_STEP = 0x9E3779B9
_WORD_FIRST = 0x21F0AAAD
_WORD_SECOND = 0xD35A2D97

_ONE = 0x3F800000  # the float32 1.0: 23 bits below make it a number in [1, 2)

# Steps, each equally likely and of either sign. As for a normal distribution, their mean fourth
# power is 3 times the square of their mean square, less 2e-6 of that square.
_STEPS = (2, 8, 12, 17, 21, 30, 34, 63)
_SIGNED_STEPS = tuple(-step for step in reversed(_STEPS)) + _STEPS
_SHAPED = ByteTable(tuple(64 + step for step in _SIGNED_STEPS))
_MIRRORED = ByteTable(tuple(64 - step for step in _SIGNED_STEPS))
_MIDDLE = 128  # of the sum of two bytes from these tables

# The rows of an orthogonal matrix: a quaternion's.
_DIRECTIONS = ((9, 7, 5, 3), (-7, 9, -3, 5), (-5, 3, 9, -7), (-3, -5, 7, 9))
_FIRST_SUM, _SECOND_SUM, _THIRD_SUM, _FOURTH_SUM = (
    ByteWeights(direction, -_MIDDLE * sum(direction)) for direction in _DIRECTIONS
)

NORMAL_DEVIATION = math.sqrt(
    2 * sum(weight**2 for weight in _DIRECTIONS[0]) * sum(step**2 for step in _STEPS) / len(_STEPS)
)
"""Standard deviation of what `eight_normals` returns."""


@numba.njit
def random_bits(key, number):
    """Return the 64 random bits of a number, an integer >= 0, under a key, both uint64."""
    bits = key + _STEP * (np.uint64(number) + np.uint64(1))
    bits = (bits ^ (bits >> np.uint64(30))) * _FIRST
    bits = (bits ^ (bits >> np.uint64(27))) * _SECOND
    return bits ^ (bits >> np.uint64(31))


@numba.njit
def uniform(bits):
    """Return a float64 in [0, 1), a multiple of 2**-24, from the upper bits."""
    return float(bits >> np.uint64(40)) * 2.0**-24


@numba.njit(forceinline=True)
def mix_tick(first_key, second_key, tick):
    """Return the two words of which all numbers of a tick are made; all are `Words`."""
    first = first_key + tick * _WORD_STEP
    first = (first ^ (first >> 16)) * _WORD_FIRST
    first = (first ^ (first >> 15)) * _WORD_SECOND
    first = first ^ (first >> 15)
    second = first ^ second_key
    second = (second ^ (second >> 16)) * _WORD_FIRST
    return first, second ^ (second >> 15)


@numba.njit(forceinline=True)
def random_words(tick_words, number):
    """Return the 32 random bits of a number, a scalar integer >= 0, in a tick, as `Words`."""
    first, second = tick_words
    bits = first + number * _WORD_STEP
    bits = (bits ^ (bits >> 16)) * _WORD_FIRST + second
    bits = (bits ^ (bits >> 15)) * _WORD_SECOND
    return bits ^ (bits >> 15)


@numba.njit(forceinline=True)
def fractions(words):
    """Return numbers in [0, 1), multiples of 2**-23, from the upper bits of `Words`."""
    return from_bits((words >> 9) | _ONE) - 1.0


@numba.njit(forceinline=True)
def eight_normals(words):
    """Return eight normal values of mean 0 and deviation `NORMAL_DEVIATION`, made of `Words`.

    Each half of each of a word's four bytes chooses one of 16 steps that have the first four
    moments of a normal distribution. The eight values are sums of these eight steps by the rows of
    an orthogonal matrix. They have these moments too, and no moment up to the fourth tells the
    eight from independent ones. Their sixth moment is 14.9 for 15, the largest value 5.66
    deviations, and they meet the distribution function within 0.001.
    """
    low = look_up(_SHAPED, words & 0x0F0F0F0F)
    high = (words >> 4) & 0x0F0F0F0F
    sums, differences = low + look_up(_SHAPED, high), low + look_up(_MIRRORED, high)
    return (
        signed(weigh(_FIRST_SUM, sums)),
        signed(weigh(_SECOND_SUM, sums)),
        signed(weigh(_THIRD_SUM, sums)),
        signed(weigh(_FOURTH_SUM, sums)),
        signed(weigh(_FIRST_SUM, differences)),
        signed(weigh(_SECOND_SUM, differences)),
        signed(weigh(_THIRD_SUM, differences)),
        signed(weigh(_FOURTH_SUM, differences)),
    )

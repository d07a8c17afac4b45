"""Random numbers by counter: a function of a key and a number, with no state to keep in order.

Two generators. SplitMix64 (Steele, Lea & Flood 2014) gives the few numbers of an episode: it steps
a counter by a constant and mixes its bits. What is drawn in every tick comes from 32-bit lanes,
for 16 robots at once: a key and the tick are mixed to two words, and each number of the tick mixes
these two once more, by multiplications and shifts (the constants are of Wellons, hash-prospector).
The numbers of an episode thus depend on its key and the tick alone: not on the lane, the thread or
the order in which episodes are played.
"""

import numba
import numpy as np

from simd_lanes import fma, from_bits, signed

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)

_WORD_STEP = 0x9E3779B9
_WORD_FIRST = 0x21F0AAAD
_WORD_SECOND = 0xD35A2D97

_ONE = 0x3F800000  # the float32 1.0: 23 bits below make it a number in [1, 2)

# c (v + r v^3) with v uniform in (-1, 1) has the fourth moment of a normal distribution and the
# variance 1/4. These are c and c r for v in units of 2**-31.
_LINEAR = 0.30392305 * 2.0**-31
_CUBIC = 0.88428461 * 2.0**-93


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
    """Return the 32 random bits of a number, a scalar integer >= 0, in a tick."""
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
def _shaped(words):
    """Return c (v + r v^3) of the words as numbers v in [-1, 1)."""
    v = signed(words)
    return v * fma(v * v, _CUBIC, _LINEAR)


@numba.njit(forceinline=True)
def four_words(tick_words, first):
    """Return the `random_words` of four numbers in a tick, the first of them given."""
    return (
        random_words(tick_words, first),
        random_words(tick_words, first + 1),
        random_words(tick_words, first + 2),
        random_words(tick_words, first + 3),
    )


@numba.njit(forceinline=True)
def four_normals(words):
    """Return four standard normal values from four `Words`.

    Sums and differences of four independent values with the first four moments of a normal
    distribution. They have these too, and no moment up to the fourth tells the four from
    independent ones. Their sixth moment is 14.8 for 15, the largest value 4.75, and they meet the
    distribution function within 0.002.
    """
    a, b, c, d = _shaped(words[0]), _shaped(words[1]), _shaped(words[2]), _shaped(words[3])
    sum_ab, sum_cd, difference_ab, difference_cd = a + b, c + d, a - b, c - d
    return (
        sum_ab + sum_cd,
        sum_ab - sum_cd,
        difference_ab + difference_cd,
        difference_ab - difference_cd,
    )


@numba.njit(forceinline=True)
def next_bits(words):
    """Return four `Words` with other bits uppermost, of which the next normal values are made.

    Eleven bits suffice for one, so a word serves three times. As a value depends on the bits below
    a little, it is correlated with that of the next bits by 1/2048.
    """
    return words[0] << 11, words[1] << 11, words[2] << 11, words[3] << 11

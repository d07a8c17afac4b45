"""Random numbers by counter: a function of a key and a number, with no state to keep in order.

SplitMix64 (Steele, Lea & Flood 2014) steps a counter by a constant and mixes its bits. Its n-th
number can be had without the ones before, so the numbers of an episode depend on that episode's
key and the tick alone: not on the lane, the thread or the order in which episodes are played.
"""

from statistics import NormalDist

import numba
import numpy as np

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)

NORMAL_BITS = 12
"""Bits of a random number that make one normal value."""


def _normal_values():
    count = 1 << NORMAL_BITS
    values = np.array([NormalDist().inv_cdf((i + 0.5) / count) for i in range(count)])
    return (values / values.std()).astype(np.float32)


NORMAL_VALUES = _normal_values()
"""float32 (4096,): equally likely values of a standard normal distribution, its quantiles from
-3.7 to 3.7, with mean 0 and standard deviation 1."""


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


@numba.njit
def normal(bits, index):
    """Return one of the five independent normal values, 0 to 4, in 64 random bits."""
    return NORMAL_VALUES[(bits >> np.uint64(NORMAL_BITS * index)) & np.uint64(4095)]

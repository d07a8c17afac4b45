"""Which episode of its perturbations a robot plays: one for each opponent."""

import numba
import numpy as np

_FACTOR = np.uint64(0x9E3779B97F4A7C15)
_STEP = np.uint64(0xD1342543DE82EF95)


@numba.njit
def episode_number(genome):
    """Return the number under which the opponents of a genome draw their random values.

    It depends on the genes alone. So a pair's episode is the same wherever and whenever it is
    played, and what an agent and its offspring meet in the same opponent is comparable.

    Parameters
    ----------
    genome : float32 array, of one dimension, C-contiguous

    Returns
    -------
    uint64
    """
    bits = genome.view(np.uint32)
    number = np.uint64(0)
    for i in range(len(genome)):
        number += np.uint64(bits[i]) * (_FACTOR * np.uint64(2 * i + 1))
    return number


@numba.njit
def repeated(number, repetition):
    """Return the number of a further episode of the same pair, with random values of its own.

    Parameters
    ----------
    number : uint64
        `episode_number` of the opponent.
    repetition : int
        From 0, which is the pair's only episode where it has no other; fresh noise counts on.
    """
    return number + np.uint64(repetition) * _STEP


def episode_numbers(genomes, repetition=0):
    """Return the `repeated` `episode_number` of each genome.

    Parameters
    ----------
    genomes : sequence of float32 arrays of one dimension
    repetition : int

    Returns
    -------
    uint64 array, shape (n,)
    """
    numbers = np.array([episode_number(genome) for genome in genomes], np.uint64)
    return numbers + np.array([repetition], np.uint64) * _STEP

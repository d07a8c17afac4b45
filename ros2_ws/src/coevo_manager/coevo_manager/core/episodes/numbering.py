"""Which episode of its perturbations a robot plays: one for each opponent."""

import numba
import numpy as np

from neuro_controller.core.genome import GENES

_FACTORS = np.uint64(0x9E3779B97F4A7C15) * (2 * np.arange(GENES, dtype=np.uint64) + np.uint64(1))


@numba.njit
def episode_number(genome):
    """Return the number under which the opponents of a genome draw their random values.

    It depends on the genes alone. So a pair's episode is the same wherever and whenever it is
    played, and what an agent and its offspring meet in the same opponent is comparable.

    Parameters
    ----------
    genome : float32 array, shape (442,), C-contiguous

    Returns
    -------
    uint64
    """
    return np.sum(genome.view(np.uint32) * _FACTORS)


def episode_numbers(genomes):
    """Return the `episode_number` of each genome.

    Parameters
    ----------
    genomes : sequence of float32 arrays, shape (442,)

    Returns
    -------
    uint64 array, shape (n,)
    """
    return np.array([episode_number(genome) for genome in genomes], np.uint64)

"""Which episode of its perturbations a robot plays: one for each opponent."""

import numpy as np

_FACTOR = np.uint64(0x9E3779B97F4A7C15)


def episode_numbers(genomes):
    """Return the number under which the opponents of each genome draw their random values.

    It depends on the genes alone. So a pair's episode is the same wherever and whenever it is
    played, and what an agent and its offspring meet in the same opponent is comparable.

    Parameters
    ----------
    genomes : float32 array, shape (n, 442)

    Returns
    -------
    uint64 array, shape (n,)
    """
    bits = np.ascontiguousarray(genomes, dtype=np.float32).view(np.uint32).astype(np.uint64)
    factors = _FACTOR * (2 * np.arange(bits.shape[1], dtype=np.uint64) + np.uint64(1))
    return (bits * factors).sum(axis=1, dtype=np.uint64)

"""Evolved controllers as policies: from sensory to motor neurons."""

from __future__ import annotations

import numpy as np

from neuro_controller.core.genome import GENES, OUTPUTS, SENSORS, check_genomes, weights_of
from neuro_controller.core.network import MEMORY_ROWS, MOTORS, recall, think
from simd_lanes import aligned_rows, compile_kernel


@compile_kernel
def _recall(weights: np.ndarray, memory: np.ndarray) -> None:
    recall(weights, memory)


@compile_kernel
def _think(weights: np.ndarray, memory: np.ndarray, inputs: np.ndarray) -> None:
    think(weights, memory, inputs)
    recall(weights, memory)


class GenomePolicy:
    """The network of a genome, computed by the kernel's own functions.

    Parameters
    ----------
    genome : array_like, shape (442,)
        Genes in [-5, 5].

    Raises
    ------
    ValueError
        It is no genome, in one sentence.

    Examples
    --------
    >>> import red_queen as rq
    >>> policy = GenomePolicy(rq.select_champion('shipped/open', 'prey').genome)
    >>> policy(np.zeros(25)).shape
    (2,)
    """

    def __init__(self, genome: np.ndarray) -> None:
        self._weights = aligned_rows(GENES)
        self._weights[:] = weights_of(check_genomes(np.atleast_2d(genome), 'genome')[:1]).T
        self._inputs = aligned_rows(SENSORS)
        self.reset()

    def reset(self) -> None:
        """Forget the past, as at the start of an episode."""
        self._memory = aligned_rows(MEMORY_ROWS)
        _recall(self._weights, self._memory)

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Return the motor neurons, float32 (2,), for sensory neurons of shape (25,)."""
        self._inputs[:] = np.asarray(observation, np.float32)[:, None]
        _think(self._weights, self._memory, self._inputs)
        return self._memory[MOTORS : MOTORS + OUTPUTS, 0].copy()

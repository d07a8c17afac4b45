"""Evolved controllers as policies: from sensory to motor neurons."""

from __future__ import annotations

import numpy as np

from neuro_controller.core.genome import OUTPUTS, Layout, check_genomes, weights_of
from neuro_controller.core.network import MOTORS, memory_rows, recall, think
from simd_lanes import aligned_rows, compile_kernel


@compile_kernel
def _recall(layout: Layout, weights: np.ndarray, memory: np.ndarray) -> None:
    recall(layout, weights, memory)


@compile_kernel
def _think(layout: Layout, weights: np.ndarray, memory: np.ndarray, inputs: np.ndarray) -> None:
    think(layout, weights, memory, inputs)
    recall(layout, weights, memory)


class GenomePolicy:
    """The network of a genome, computed by the kernel's own functions.

    Parameters
    ----------
    genome : array_like, shape (genes,)
        Genes in [-5, 5]; their number tells that of the hidden neurons.

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
        self._layout = Layout.of(np.size(genome))
        genomes = check_genomes(np.reshape(genome, (1, -1)), 'genome', self._layout)
        self._weights = aligned_rows(self._layout.genes)
        self._weights[:] = weights_of(genomes, self._layout).T
        self._inputs = aligned_rows(self._layout.inputs)
        self.reset()

    def reset(self) -> None:
        """Forget the past, as at the start of an episode."""
        self._memory = aligned_rows(memory_rows(self._layout))
        _recall(self._layout, self._weights, self._memory)

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Return the motor neurons, float32 (2,), for sensory neurons of shape (inputs,)."""
        self._inputs[:] = np.asarray(observation, np.float32)[:, None]
        _think(self._layout, self._weights, self._memory, self._inputs)
        return self._memory[MOTORS : MOTORS + OUTPUTS, 0].copy()

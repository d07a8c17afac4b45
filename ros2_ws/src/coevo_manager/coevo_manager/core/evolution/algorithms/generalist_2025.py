"""The Generalist as it was compared with archives (Nolfi and Pagliuca 2025)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.comparison import OPENAI_ES
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER


class Generalist2025(Algorithm):
    """Random agents against opponents that differ; who does best against all stays."""

    defaults: ClassVar[Mapping[str, Any]] = {
        **OPENAI_ES,
        'openai_agent': 'centre',
        'generations': 20,
        'swap_generations': 20,
        'snapshot_generations': 20,
    }

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Take one at random, then those that differ most from the ones taken."""
        species = OTHER[state.evolving]
        fitness = state.fitness(species)
        index = most_different(
            fitness, self.configuration.selected, int(rng.integers(len(fitness)))
        )
        return Opponents(state.genomes(species)[index], index)

    def agents(self, fitness: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Take different ones at random."""
        return rng.permutation(len(fitness))[: self.configuration.selected]

    def scores(self, contest: Contest) -> np.ndarray:
        """Sum fitness over the whole opposing population."""
        return contest.fitness.sum(axis=1, dtype=np.int64)


def most_different(vectors: np.ndarray, count: int, first: int) -> np.ndarray:
    """Choose rows one by one, each the one that differs most in sum from those chosen.

    Parameters
    ----------
    vectors : int (N, D)
        What is known of each individual: its fitness against each of D agents.
    count : int
    first : int
        The row to begin with. Of equal ones the lowest is taken.

    Returns
    -------
    int64 (count,)
    """
    vectors = vectors.astype(np.int64)
    chosen = [first]
    difference = np.zeros(len(vectors), np.int64)
    for _ in range(count - 1):
        difference += abs(vectors - vectors[chosen[-1]]).sum(axis=1)
        difference[chosen] = -1
        chosen.append(int(difference.argmax()))
    return np.array(chosen)

"""The control condition Simplified (Simione and Nolfi 2019, section 2.1)."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.selection import fittest
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER


class Simplified(Algorithm):
    """The fittest opponents, and survivors ranked by plain mean fitness."""

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Take the n opponents of highest mean fitness."""
        species = OTHER[state.evolving]
        fitness = state.fitness(species).sum(axis=1, dtype=np.int64)
        index = fittest(fitness, self.configuration.selected)
        return Opponents(state.genomes(species)[index], index)

    def scores(self, contest: Contest) -> np.ndarray:
        """Sum fitness over the whole opposing population."""
        return contest.fitness.sum(axis=1, dtype=np.int64)

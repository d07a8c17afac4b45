"""Control: freshly random opponents (Chong, Tino and Yao 2008)."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.state import State
from neuro_controller.core.genome import random_genomes


class RandomOpponents(Algorithm):
    """Each phase evolves and ranks against n opponents drawn at random.

    What is optimised is directly the expected result against any opponent, but the opponents
    never get stronger.
    """

    external_opponents = True

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Draw n new genomes."""
        return Opponents(
            random_genomes(self.configuration.selected, rng, self.configuration.layout)
        )

    def scores(self, contest: Contest) -> np.ndarray:
        """Sum fitness over the random opponents."""
        return contest.training

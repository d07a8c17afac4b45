"""The control condition Vanilla (Simione and Nolfi 2019, section 2.1)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER


class Vanilla(Algorithm):
    """Everyone evolves against everyone: the Standard condition with n = N.

    No opponent is left for validation, so that nothing filters out opportunistic agents. The paper
    does not state its N; with N = n = 10 a generation costs what it costs in the Standard
    condition.
    """

    defaults: ClassVar = {'population': 10}

    @staticmethod
    def default_selected(population: int) -> int:
        """Return the whole population."""
        return population

    @staticmethod
    def check(configuration: Configuration) -> None:
        """Demand that everyone be selected."""
        if configuration.selected != configuration.population:
            raise ValueError(
                f'selected is {configuration.selected}, expected the population, '
                f'{configuration.population}, in the algorithm vanilla'
            )

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Take the whole opposing population."""
        genomes = state.genomes(OTHER[state.evolving])
        return Opponents(genomes, np.arange(len(genomes)))

    def agents(self, fitness: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Take the whole evolving population."""
        return np.arange(len(fitness))

    def scores(self, contest: Contest) -> np.ndarray:
        """Weigh opponents by their own fitness."""
        return self.weighted(contest)

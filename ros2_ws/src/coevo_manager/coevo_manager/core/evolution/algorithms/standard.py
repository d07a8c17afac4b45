"""The generalist algorithm, condition Standard (Simione and Nolfi 2019, section 2.1)."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.selection import cluster, fittest_of_groups
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER


class Standard(Algorithm):
    """Well-differentiated opponents, and survivors that do well against strong opponents."""

    @staticmethod
    def check(configuration: Configuration) -> None:
        """Demand that N / n be a power of two, so that groups merge in pairs."""
        population, selected = configuration.population, configuration.selected
        ratio, rest = divmod(population, selected)
        if rest or ratio & (ratio - 1):
            raise ValueError(
                f'population / selected is {population} / {selected}, expected a power of two in '
                'the algorithm standard'
            )

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Cluster the opponents by what they achieve; take the fittest of each cluster."""
        species = OTHER[state.evolving]
        fitness = state.fitness(species)
        groups = cluster(fitness, self.configuration.selected)
        index = fittest_of_groups(groups, fitness.sum(axis=1, dtype=np.int64))
        return Opponents(state.genomes(species)[index], index)

    def scores(self, contest: Contest) -> np.ndarray:
        """Weigh opponents by their own fitness."""
        return self.weighted(contest)

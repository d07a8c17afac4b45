"""The (1+1) evolution strategy (Rechenberg 1973), as Simione and Nolfi (2019) use it."""

from __future__ import annotations

import collections

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import Mutation, mutations
from coevo_manager.core.evolution.optimizer import Optimizer
from neuro_controller.core.genome import GENE_RANGE


class OnePlusOne(Optimizer):
    """One parent, one mutated offspring a generation, which replaces it if as fit or fitter."""

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(parent, fitness, configuration, rng)
        self._mutations = mutations(
            configuration.mutation, len(parent), configuration.mutation_rate, GENE_RANGE, rng
        )
        self._drawn: collections.deque[Mutation] = collections.deque()
        self._offspring: collections.deque[np.ndarray] = collections.deque()

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count one offspring."""
        return 1

    def ask(self) -> np.ndarray:
        """Mutate the parent."""
        return self.ask_ahead(1)[0]

    def ask_ahead(self, generations: int) -> np.ndarray:
        """Mutate the parent by each of the next mutations, which no outcome changes."""
        while len(self._drawn) < generations:
            self._drawn.append(next(self._mutations))
        offspring = np.repeat(self.best[np.newaxis, np.newaxis], generations, axis=0)
        for (genome,), (genes, values) in zip(offspring, self._drawn, strict=False):
            genome[genes] = values
        self._offspring = collections.deque(offspring)
        return offspring

    def tell(self, fitness: np.ndarray) -> bool:
        """Keep the better of parent and offspring."""
        self._drawn.popleft()
        return self._keep_best(self._offspring.popleft(), fitness)

"""The (1+1) evolution strategy (Rechenberg 1973), as Simione and Nolfi (2019) use it."""

from __future__ import annotations

import collections
import itertools
from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import Mutation, draw_mutations
from coevo_manager.core.evolution.optimizer import Optimizer
from marxbot_sim.core.fields import Option
from neuro_controller.core.genome import GENE_RANGE


class OnePlusOne(Optimizer):
    """One parent, one mutated offspring a generation, which replaces it if as fit or fitter."""

    parameters: ClassVar = (
        Option(
            'mutation',
            str,
            'bernoulli',
            'each gene is redrawn with the mutation rate, or exactly that share of the genes',
            choices=('bernoulli', 'exact'),
        ),
        Option('mutation_rate', float, 0.02, 'share of genes redrawn', minimum=0.0, maximum=1.0),
    )

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(parent, fitness, configuration, rng)
        self._draws = draw_mutations(
            configuration.mutation, len(parent), configuration.mutation_rate, GENE_RANGE, rng
        )
        self._ahead: collections.deque[Mutation] = collections.deque()

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count one offspring."""
        return 1

    def ask(self) -> np.ndarray:
        """Mutate the parent."""
        offspring = self.best.copy()
        _mutate(offspring, *self.mutations(1))
        return offspring[np.newaxis]

    def mutations(self, generations: int) -> list[Mutation]:
        """Return the next mutations, which no outcome changes."""
        while len(self._ahead) < generations:
            self._ahead.append(next(self._draws))
        return list(itertools.islice(self._ahead, generations))

    def tell(self, fitness: np.ndarray) -> bool:
        """Keep the better of parent and offspring."""
        mutation = self._ahead.popleft()
        if fitness[0] < self.best_fitness:
            return False
        _mutate(self.best, mutation)
        self.best_fitness = float(fitness[0])
        return True


def _mutate(genome: np.ndarray, mutation: Mutation) -> None:
    genes, values = mutation
    genome[genes] = values

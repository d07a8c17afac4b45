"""The (1+1) evolution strategy (Rechenberg 1973), as Simione and Nolfi (2019) use it."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import Mutations, draw_mutations
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
        self._drawn = Mutations(
            np.empty(0, np.uint32), np.empty(0, np.uint32), np.empty(0, np.float32)
        )
        self._starts = [0]
        self._told = 0

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count one offspring."""
        return 1

    def ask(self) -> np.ndarray:
        """Mutate the parent."""
        offspring, mutation = self.best.copy(), self.mutations(1)
        offspring[mutation.genes] = mutation.values
        return offspring[np.newaxis]

    def mutations(self, generations: int) -> Mutations:
        """Return the next mutations, which no outcome changes."""
        while len(self._drawn.redrawn) - self._told < generations:
            rest, block = self._next(len(self._drawn.redrawn) - self._told), next(self._draws)
            self._drawn = Mutations(
                np.concatenate((rest.redrawn, block.redrawn)),
                np.concatenate((rest.genes, block.genes)),
                np.concatenate((rest.values, block.values)),
            )
            self._starts = [0, *np.cumsum(self._drawn.redrawn).tolist()]
            self._told = 0
        return self._next(generations)

    def tell(self, fitness: np.ndarray) -> bool:
        """Keep the better of parent and offspring."""
        mutated = slice(self._starts[self._told], self._starts[self._told + 1])
        self._told += 1
        if fitness[0] < self.best_fitness:
            return False
        self.best[self._drawn.genes[mutated]] = self._drawn.values[mutated]
        self.best_fitness = float(fitness[0])
        return True

    def _next(self, generations: int) -> Mutations:
        end = self._told + generations
        changes = slice(self._starts[self._told], self._starts[end])
        return Mutations(
            self._drawn.redrawn[self._told : end],
            self._drawn.genes[changes],
            self._drawn.values[changes],
        )

"""The (1+1) evolution strategy (Rechenberg 1973), as Simione and Nolfi (2019) use it."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import mutations
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
        self._offspring = np.empty((1, len(parent)), np.float32)

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count one offspring."""
        return 1

    def ask(self) -> np.ndarray:
        """Mutate the parent."""
        genes, values = next(self._mutations)
        offspring = self._offspring[0]
        offspring[:] = self.best
        offspring[genes] = values
        return self._offspring

    def tell(self, fitness: np.ndarray) -> bool:
        """Keep the better of parent and offspring."""
        return self._keep_best(self._offspring, fitness)

"""CMA-ES (Hansen and Ostermeier 2001) by pycma, with a diagonal covariance."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.optimizer import Optimizer
from marxbot_sim.core.fields import Option
from neuro_controller.core.genome import GENE_RANGE


class CmaEs(Optimizer):
    """Separable CMA-ES (Ros and Hansen 2008): linear in the number of genes.

    A full covariance of all genes could not be learned within a phase, and costs a hundred times
    more. Genes are kept in their limits by pycma's boundary transformation.
    """

    parameters: ClassVar = (
        Option('cma_candidates', int, 20, 'candidates a generation', 'genomes', 4, 10_000),
        Option('cma_sigma', float, 0.5, 'first step size', 'genes', 1e-6, 10.0),
    )

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(parent, fitness, configuration, rng)
        import cma  # here, since it takes seconds to load

        self._strategy = cma.CMAEvolutionStrategy(
            parent.astype(float),
            configuration.cma_sigma,
            {
                'popsize': configuration.cma_candidates,
                'CMA_diagonal': True,
                'bounds': [-GENE_RANGE, GENE_RANGE],
                'randn': lambda *shape: rng.standard_normal(shape),
                'seed': np.nan,  # pycma leaves NumPy's global generator alone
                'verbose': -9,
            },
        )

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Return the population size of CMA-ES."""
        return configuration.cma_candidates

    def ask(self) -> np.ndarray:
        """Sample the search distribution."""
        self._solutions = self._strategy.ask()
        self._genomes = np.array(self._solutions, np.float32)
        return self._genomes

    def tell(self, fitness: np.ndarray) -> bool:
        """Update the search distribution."""
        self._strategy.tell(self._solutions, (-fitness).tolist())
        return self._keep_best(self._genomes, fitness)

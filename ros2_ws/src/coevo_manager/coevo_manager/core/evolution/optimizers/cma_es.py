"""CMA-ES (Hansen and Ostermeier 2001) with a diagonal covariance (Ros and Hansen 2008)."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.optimizer import Optimizer
from marxbot_sim.core.fields import Option
from neuro_controller.core.genome import GENE_RANGE

TREND_RATE = 0.3
"""Share of the newest generation in what is known of longer steps."""


class CmaEs(Optimizer):
    """Separable CMA-ES: linear in the number of genes.

    A full covariance of all genes could not be learned within a phase, and costs a hundred times
    more. Weights and rates are those of Hansen's tutorial (2016), where rates of n variances are
    (n + 2) / 3 times as high (Ros and Hansen 2008, section 3). The step size is learned from two
    candidates, which go on with the last move of the mean and take it back (Hansen 2008), with the
    constants of pycma. The search itself has no limits: genes beyond theirs are reflected.
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
        n, k = len(parent), configuration.cma_candidates
        self._rng = rng
        self._shape = k, n
        self._mean = parent.astype(float)
        self._variances = np.ones(n)
        self._deviations = np.ones(n)
        self._path = np.zeros(n)
        self._move: np.ndarray | None = None
        self._sigma = configuration.cma_sigma
        self._trend = 0.0
        self._damping = 0.7 + 2 * math.log(n)

        weights = math.log((k + 1) / 2) - np.log(np.arange(1, k // 2 + 1))
        self._weights = weights / weights.sum()
        mass = float(1 / (self._weights**2).sum())
        rate = (4 + mass / n) / (n + 4 + 2 * mass / n)
        self._path_rate = rate
        self._path_step = math.sqrt(rate * (2 - rate) * mass)
        one = 2 / ((n + 1.3) ** 2 + mass)
        many = 2 * (mass - 2 + 1 / mass) / ((n + 2) ** 2 + mass)
        self._rate_of_path, self._rate_of_best = one * (n + 2) / 3, many * (n + 2) / 3

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Return the population size of CMA-ES."""
        return configuration.cma_candidates

    def ask(self) -> np.ndarray:
        """Sample the search distribution."""
        self._noise = self._rng.standard_normal(self._shape)
        if self._move is not None:
            length = math.sqrt((self._noise[0] ** 2).sum() / (self._move**2).sum())
            self._noise[0] = length * self._move
            self._noise[1] = -self._noise[0]
        genomes = reflect(self._mean + self._sigma * self._deviations * self._noise)
        self._genomes = genomes.astype(np.float32)
        return self._genomes

    def tell(self, fitness: np.ndarray) -> bool:
        """Update the search distribution."""
        if self._move is not None:
            on, back = (fitness > fitness[0]).sum(), (fitness > fitness[1]).sum()
            lead = (back - on) / (len(fitness) - 1)
            lead = math.copysign(math.sqrt(abs(lead)), lead)
            self._trend += TREND_RATE * (lead - self._trend)
        best = self._noise[np.argsort(-fitness, kind='stable')[: len(self._weights)]]
        self._move = self._weights @ best
        step = self._deviations * self._move
        self._mean += self._sigma * step
        self._sigma *= math.exp(self._trend / self._damping)

        self._path += self._path_step * step - self._path_rate * self._path
        one, many = self._rate_of_path, self._rate_of_best
        self._variances *= 1 - one - many + many * (self._weights @ best**2)
        self._variances += one * self._path**2
        self._deviations = np.sqrt(self._variances)
        return self._keep_best(self._genomes, fitness)


def reflect(genes: np.ndarray) -> np.ndarray:
    """Return genes within their limits, each limit being a mirror."""
    period = 4 * GENE_RANGE
    genes = genes - period * np.rint(genes / period)
    return 2 * np.clip(genes, -GENE_RANGE, GENE_RANGE) - genes

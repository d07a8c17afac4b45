"""OpenAI-ES (Salimans et al. 2017) with Adam (Kingma and Ba 2015)."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.optimizer import Optimizer
from neuro_controller.core.genome import GENE_RANGE

ADAM_BETA1 = 0.9
ADAM_BETA2 = 0.999
ADAM_EPSILON = 1e-8


class OpenAiEs(Optimizer):
    """Gradient ascent on the mean fitness of a Gaussian around a centre.

    A generation evaluates the centre and mirrored pairs of samples around it. The gradient is
    estimated from the samples' centred ranks (Salimans et al., section 2.1) and followed by Adam.
    The agent is the fittest genome evaluated, be it a centre or a sample.
    """

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(parent, fitness, configuration, rng)
        self._rng = rng
        self._pairs = configuration.openai_pairs
        self._sigma = configuration.openai_sigma
        self._step = configuration.openai_step
        self._centre = parent.astype(float)
        self._momentum = np.zeros(len(parent))
        self._variance = np.zeros(len(parent))
        self._updates = 0

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count the centre and the mirrored pairs."""
        return 1 + 2 * configuration.openai_pairs

    def ask(self) -> np.ndarray:
        """Return the centre, then one half of the pairs, then the other."""
        self._noise = self._rng.standard_normal((self._pairs, len(self._centre)))
        steps = self._sigma * self._noise
        genomes = self._centre + np.concatenate((np.zeros((1, steps.shape[1])), steps, -steps))
        self._genomes = np.clip(genomes, -GENE_RANGE, GENE_RANGE).astype(np.float32)
        return self._genomes

    def tell(self, fitness: np.ndarray) -> bool:
        """Move the centre along the estimated gradient."""
        utilities = centred_ranks(fitness[1:])
        weights = utilities[: self._pairs] - utilities[self._pairs :]
        gradient = weights @ self._noise / (2 * self._pairs * self._sigma)
        self._updates += 1
        self._momentum += (1 - ADAM_BETA1) * (gradient - self._momentum)
        self._variance += (1 - ADAM_BETA2) * (gradient**2 - self._variance)
        momentum = self._momentum / (1 - ADAM_BETA1**self._updates)
        variance = self._variance / (1 - ADAM_BETA2**self._updates)
        self._centre += self._step * momentum / (np.sqrt(variance) + ADAM_EPSILON)
        np.clip(self._centre, -GENE_RANGE, GENE_RANGE, out=self._centre)
        return self._keep_best(self._genomes, fitness)


def centred_ranks(fitness: np.ndarray) -> np.ndarray:
    """Return ranks scaled to [-0.5, 0.5], the worst first; equal ones share their mean rank."""
    _, inverse, counts = np.unique(fitness, return_inverse=True, return_counts=True)
    mean_ranks = np.cumsum(counts) - (counts + 1) / 2
    return mean_ranks[inverse] / (len(fitness) - 1) - 0.5

"""OpenAI-ES (Salimans et al. 2017) with Adam (Kingma and Ba 2015)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.optimizer import Optimizer
from marxbot_sim.core.fields import Option
from neuro_controller.core.genome import GENE_RANGE

ADAM_BETA1 = 0.9
ADAM_BETA2 = 0.999
ADAM_EPSILON = 1e-8


class OpenAiEs(Optimizer):
    """Gradient ascent on the mean fitness of a Gaussian around a centre.

    A generation evaluates the centre and mirrored pairs of samples around it. The gradient is
    estimated from the samples' centred ranks (Salimans et al., section 2.1), weights decay toward
    zero by a share of the genes, and Adam follows. Adam's moments, and how many updates they have
    seen, are the optimizer's memory.
    """

    parameters: ClassVar = (
        Option(
            'openai_pairs', int, 10, 'mirrored pairs of samples a generation', 'pairs', 1, 10_000
        ),
        Option(
            'openai_sigma', float, 0.2, 'standard deviation of the samples', 'genes', 1e-6, 10.0
        ),
        Option('openai_step', float, 0.05, "Adam's step size", 'genes', 0.0, 10.0),
        Option(
            'openai_decay',
            float,
            0.0,
            'share of each gene that is taken from its gradient of fitness ranks, per gene',
            minimum=0.0,
            maximum=1.0,
        ),
        Option(
            'openai_agent',
            str,
            'best',
            'the evolved agent: the fittest genome evaluated in a phase, the fittest of its last '
            'generation, or the centre',
            choices=('best', 'latest', 'centre'),
        ),
    )

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
        memory: np.ndarray | None = None,
    ) -> None:
        super().__init__(parent, fitness, configuration, rng)
        self._rng = rng
        self._pairs = configuration.openai_pairs
        self._sigma = configuration.openai_sigma
        self._step = configuration.openai_step
        self._decay = configuration.openai_decay
        self._agent = configuration.openai_agent
        self._centre = parent.astype(float)
        if memory is None:
            memory = np.zeros(self.memory_size(len(parent)))
        genes = len(parent)
        self._momentum: np.ndarray = memory[:genes].copy()
        self._variance: np.ndarray = memory[genes : 2 * genes].copy()
        self._updates = int(memory[-1])

    @staticmethod
    def candidates(configuration: Configuration) -> int:
        """Count the centre and the mirrored pairs."""
        return 1 + 2 * configuration.openai_pairs

    @staticmethod
    def groups(configuration: Configuration) -> np.ndarray:
        """Return 0 for the centre, then 1, 2, ... for the pairs' halves."""
        pairs = np.arange(1, configuration.openai_pairs + 1)
        return np.concatenate(([0], pairs, pairs))

    @staticmethod
    def compares_generations(configuration: Configuration) -> bool:
        """Tell whether the agent is the fittest of all generations."""
        return configuration.openai_agent == 'best'

    @staticmethod
    def memory_size(genes: int) -> int:
        """Count both moments of each gene, and the number of updates."""
        return 2 * genes + 1

    @property
    def memory(self) -> np.ndarray:
        """Momentum, variance, number of updates."""
        return np.concatenate((self._momentum, self._variance, [self._updates]))

    @property
    def position(self) -> np.ndarray:
        """The centre."""
        return self._centre.astype(np.float32)

    def ask(self) -> np.ndarray:
        """Return the centre, then one half of the pairs, then the other."""
        self._noise = self._rng.standard_normal((self._pairs, len(self._centre)))
        steps = self._sigma * self._noise
        genomes = np.concatenate(
            (self._centre[np.newaxis], self._centre + steps, self._centre - steps)
        )
        self._genomes = genomes.clip(-GENE_RANGE, GENE_RANGE).astype(np.float32)
        return self._genomes

    def tell(self, fitness: np.ndarray) -> bool:
        """Move the centre along the estimated gradient."""
        utilities = centred_ranks(fitness[1:])
        weights = utilities[: self._pairs] - utilities[self._pairs :]
        gradient = weights @ self._noise / (2 * self._pairs * self._sigma)
        if self._decay:
            gradient -= self._decay * self._centre
        self._updates += 1
        self._momentum += (1 - ADAM_BETA1) * (gradient - self._momentum)
        self._variance += (1 - ADAM_BETA2) * (gradient**2 - self._variance)
        momentum = self._momentum / (1 - ADAM_BETA1**self._updates)
        variance = self._variance / (1 - ADAM_BETA2**self._updates)
        self._centre += self._step * momentum / (np.sqrt(variance) + ADAM_EPSILON)
        np.clip(self._centre, -GENE_RANGE, GENE_RANGE, out=self._centre)
        if self._agent == 'best':
            return self._keep_best(self._genomes, fitness)
        if self._agent == 'centre':
            self.best[:] = self._centre
            self.best_fitness = float(fitness[0])
        else:
            winner = fitness.argmax()
            self.best[:] = self._genomes[winner]
            self.best_fitness = float(fitness[winner])
        return True


def centred_ranks(fitness: np.ndarray) -> np.ndarray:
    """Return ranks scaled to [-0.5, 0.5], the worst first; equal ones share their mean rank."""
    ordered = np.sort(fitness)
    worse = ordered.searchsorted(fitness)
    not_better = ordered.searchsorted(fitness, 'right')
    return (worse + not_better - 1) / 2 / (len(fitness) - 1) - 0.5

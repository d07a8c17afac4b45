"""What evolves one agent within a phase: ask for candidates, tell their fitness."""

from __future__ import annotations

import abc

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import Mutation


class Optimizer(abc.ABC):
    """Improves one genome against fixed opponents; it lives for one phase.

    Parameters
    ----------
    parent : float32 (genes,)
        The genome it starts from.
    fitness : float
        The parent's mean fitness over the phase's opponents, 0 to 1.
    configuration : Configuration
    rng : Generator
        The only source of its random draws.

    Attributes
    ----------
    best : float32 (genes,)
        The fittest genome known; the newest of equal ones.
    best_fitness : float
    """

    def __init__(
        self,
        parent: np.ndarray,
        fitness: float,
        configuration: Configuration,
        rng: np.random.Generator,
    ) -> None:
        self.best = parent.copy()
        self.best_fitness = fitness

    @staticmethod
    @abc.abstractmethod
    def candidates(configuration: Configuration) -> int:
        """Return the number k of candidates a generation."""

    @abc.abstractmethod
    def ask(self) -> np.ndarray:
        """Return candidates to evaluate, float32 (k, genes), each gene in its limits."""

    def mutations(self, generations: int) -> list[Mutation] | None:
        """Return the mutations of the next generations, where those are all there is to ask.

        Each generation then has one candidate, ``best`` with some genes redrawn, that takes its
        place if it is as fit or fitter. All are told in turn, as if each had been asked for. None
        from an optimizer whose candidates depend on more than that.
        """
        del generations
        return None

    @abc.abstractmethod
    def tell(self, fitness: np.ndarray) -> bool:
        """Take the candidates' mean fitness, float64 (k,); True when ``best`` was replaced."""

    def _keep_best(self, candidates: np.ndarray, fitness: np.ndarray) -> bool:
        """Replace ``best`` by the fittest candidate if that is as fit or fitter."""
        winner = fitness.argmax()
        if fitness[winner] < self.best_fitness:
            return False
        self.best[:] = candidates[winner]
        self.best_fitness = float(fitness[winner])
        return True

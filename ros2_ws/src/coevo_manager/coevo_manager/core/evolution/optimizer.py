"""What evolves one agent within a phase: ask for candidates, tell their fitness."""

from __future__ import annotations

import abc
from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.mutation import Mutations
from marxbot_sim.core.fields import Option


class Optimizer(abc.ABC):
    """Improves one genome against the opponents of a phase; it lives for that phase.

    Parameters
    ----------
    parent : float32 (genes,)
        The genome it starts from.
    fitness : float
        The parent's mean fitness over the phase's opponents, 0 to 1.
    configuration : Configuration
    rng : Generator
        The only source of its random draws.
    memory : float64 (memory_size,), optional
        What an optimizer learned that evolved this genome before; all zeros from one that did not
        begin yet. Given only where there is something to remember.

    Attributes
    ----------
    parameters : tuple of Option
        The optimizer's own fields of a configuration.
    best : float32 (genes,)
        The evolved agent: the fittest genome known, the newest of equal ones, where the optimizer
        does not say otherwise.
    best_fitness : float
        Of ``best``, or of what it is judged by.
    """

    parameters: ClassVar[tuple[Option, ...]] = ()

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

    @classmethod
    def groups(cls, configuration: Configuration) -> np.ndarray:
        """Return a number for each candidate, int (k,): equal ones must meet equal opponents."""
        return np.zeros(cls.candidates(configuration), np.int64)

    @staticmethod
    def compares_generations(configuration: Configuration) -> bool:
        """Tell whether fitness is compared with that of former generations."""
        del configuration
        return True

    @staticmethod
    def memory_size(genes: int) -> int:
        """Return how many numbers the optimizer remembers of an individual; 0 where none."""
        del genes
        return 0

    @property
    def memory(self) -> np.ndarray:
        """What another optimizer needs to go on from `position`, float64 (memory_size,)."""
        return np.zeros(0)

    @property
    def position(self) -> np.ndarray:
        """Where the search would go on, float32 (genes,)."""
        return self.best.copy()

    @abc.abstractmethod
    def ask(self) -> np.ndarray:
        """Return candidates to evaluate, float32 (k, genes), each gene in its limits."""

    def mutations(self, generations: int) -> Mutations | None:
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

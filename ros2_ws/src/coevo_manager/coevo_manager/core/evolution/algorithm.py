"""What an algorithm decides: opponents and agents of a phase, and who stays."""

from __future__ import annotations

import abc
import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.ranking import opponent_weights, weighted_scores
from coevo_manager.core.evolution.selection import best_against_each
from coevo_manager.core.evolution.state import State


@dataclasses.dataclass(frozen=True)
class Opponents:
    """The opponents of a phase.

    Attributes
    ----------
    genomes : float32 (m, 442)
    index : int (m,), optional
        Their places in the opposing population, whose results are known; None when they come
        from elsewhere, and the incumbents are first evaluated against them.
    """

    genomes: np.ndarray
    index: np.ndarray | None = None


@dataclasses.dataclass(frozen=True)
class Contest:
    """The N incumbents followed by the n evolved agents, to be ranked at the end of a phase.

    Attributes
    ----------
    fitness : int (N + n, N)
        Fitness against each individual of the opposing population, in ticks.
    training : int64 (N + n,)
        Fitness summed over the phase's opponents, in ticks.
    pair_ticks : int
        Most fitness against one opponent, in ticks.
    """

    fitness: np.ndarray
    training: np.ndarray
    pair_ticks: int


class Algorithm(abc.ABC):
    """One way to co-evolve; its state between phases is in `arrays`.

    Attributes
    ----------
    defaults : dict
        Fields of the configuration that the algorithm changes where they are not given.
    external_opponents : bool
        Opponents come from outside the opposing population: each phase first evaluates the N
        incumbents against them.
    """

    defaults: ClassVar[Mapping[str, Any]] = {}
    external_opponents = False

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration

    @staticmethod
    def default_selected(population: int) -> int:
        """Return n where none is given: N / 8, or N / 4, N / 2, N, the first that is whole."""
        return population // math.gcd(population, 8)

    @staticmethod
    def check(configuration: Configuration) -> None:
        """Raise ValueError, in one sentence, where the algorithm cannot run so."""
        del configuration

    @abc.abstractmethod
    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Choose the opponents of the next phase."""

    def agents(self, fitness: np.ndarray) -> np.ndarray:
        """Choose the agents of the next phase.

        Parameters
        ----------
        fitness : int (N, m)
            Incumbents' fitness against each of the phase's opponents, in ticks.

        Returns
        -------
        int64 (n,)
        """
        return best_against_each(fitness, self.configuration.agent_selection == 'distinct')

    @abc.abstractmethod
    def scores(self, contest: Contest) -> np.ndarray:
        """Score everyone in a contest, (N + n,); the highest stay."""

    def weighted(self, contest: Contest) -> np.ndarray:
        """Score by fitness weighted with the opponents' own fitness."""
        counted = contest.fitness
        if self.configuration.ranking_weights == 'incumbents':
            counted = counted[: self.configuration.population]
        return weighted_scores(contest.fitness, opponent_weights(counted, contest.pair_ticks))

    def remember(self, state: State, species: str) -> None:  # noqa: B027 (optional)
        """Take note of a population that has just changed."""

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what the algorithm must keep in a checkpoint."""
        return {}

    def restore(self, arrays: dict[str, np.ndarray]) -> None:  # noqa: B027 (optional)
        """Take back what `arrays` returned."""

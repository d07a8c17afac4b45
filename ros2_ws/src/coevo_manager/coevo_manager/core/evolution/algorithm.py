"""What an algorithm decides: opponents and agents of a phase, and who stays."""

from __future__ import annotations

import abc
import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.matchup import Agents, Evolved, Opponents
from coevo_manager.core.evolution.ranking import (
    opponent_weights,
    replacements,
    weighted_scores,
)
from coevo_manager.core.evolution.selection import best_against_each
from coevo_manager.core.evolution.state import State, fitness_of
from coevo_manager.core.species import OTHER
from marxbot_sim.core.fields import Option


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
    """One way to co-evolve; its state between phases is in `arrays` and its journals.

    As it stands it takes agents from the population, the best against each opponent, and ranks
    them with the incumbents when they have evolved. One that works otherwise replaces `start` and
    `settle`.

    Attributes
    ----------
    parameters : tuple of Option
        The algorithm's own fields of a configuration.
    defaults : dict
        Fields of the configuration that the algorithm changes where they are not given.
    external_opponents : bool
        Opponents come from outside the opposing population: each phase first evaluates the N
        incumbents against them.
    journals : dict of str to dtype
        Files of rows that are only ever added, such as the members of an archive, by their names
        in the run folder.
    """

    parameters: ClassVar[tuple[Option, ...]] = ()
    defaults: ClassVar[Mapping[str, Any]] = {}
    external_opponents = False
    journals: ClassVar[Mapping[str, np.dtype]] = {}

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self._news: dict[str, list[np.ndarray]] = {name: [] for name in self.journals}

    @staticmethod
    def default_selected(population: int) -> int:
        """Return n where none is given: N / 8, or N / 4, N / 2, N, the first that is whole."""
        return population // math.gcd(population, 8)

    @staticmethod
    def check(configuration: Configuration) -> None:
        """Raise ValueError, in one sentence, where the algorithm cannot run so."""
        del configuration

    @classmethod
    def lineages(cls, configuration: Configuration) -> int:
        """Return how many agents evolve in a phase."""
        return configuration.selected

    def rivals(self, state: State) -> np.ndarray:
        """Return whom the agents meet when they have evolved, float32 (rivals, genes)."""
        return state.genomes(OTHER[state.evolving])

    @abc.abstractmethod
    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Choose the opponents of the next phase."""

    def agents(self, fitness: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Choose the agents of the next phase.

        Parameters
        ----------
        fitness : int (N, m)
            Incumbents' fitness against each of the phase's opponents, in ticks.
        rng : Generator

        Returns
        -------
        int64 (n,)
        """
        del rng
        return best_against_each(fitness, self.configuration.agent_selection == 'distinct')

    def start(self, state: State, fitness: np.ndarray | None, rng: np.random.Generator) -> Agents:
        """Return the agents of the next phase; ``fitness`` as in `agents`, None if unknown."""
        assert fitness is not None
        chosen = self.agents(fitness, rng)
        species = state.evolving
        return Agents(
            state.genomes(species)[chosen],
            fitness[chosen].sum(axis=1, dtype=np.int64),
            state.memory[species][chosen],
            chosen,
        )

    def settle(
        self, state: State, agents: Agents, fitness: np.ndarray | None, evolved: Evolved
    ) -> int:
        """Decide who stays in the population, and return how many of the evolved do."""
        if self.configuration.replacement == 'evolved':
            assert agents.places is not None
            places, retained = agents.places, np.arange(len(agents.places))
        else:
            assert fitness is not None
            new = fitness_of(state.evolving, evolved.capture_ticks, state.pair_ticks)
            contest = Contest(
                np.concatenate((state.fitness(state.evolving), new)),
                np.concatenate((fitness.sum(axis=1, dtype=np.int64), evolved.training)),
                state.pair_ticks,
            )
            places, retained = replacements(self.scores(contest), self.configuration.population)
        state.replace(
            places,
            evolved.genomes[retained],
            evolved.capture_ticks[retained],
            evolved.memory[retained],
        )
        return len(retained)

    def scores(self, contest: Contest) -> np.ndarray:
        """Score everyone in a contest, (N + n,); the highest stay."""
        raise NotImplementedError

    def weighted(self, contest: Contest) -> np.ndarray:
        """Score by fitness weighted with the opponents' own fitness."""
        counted = contest.fitness
        if self.configuration.ranking_weights == 'incumbents':
            counted = counted[: self.configuration.population]
        return weighted_scores(contest.fitness, opponent_weights(counted, contest.pair_ticks))

    def remember(self, state: State, species: str) -> None:  # noqa: B027 (optional)
        """Take note of a population that has just changed."""

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what the algorithm must keep in a checkpoint, besides its journals."""
        return {}

    def note(self, journal: str, rows: np.ndarray) -> None:
        """Add rows to a journal."""
        self._news[journal].append(np.array(rows, ndmin=1))

    def news(self) -> dict[str, bytes]:
        """Return what was noted in each journal since the last call."""
        found = {
            name: b''.join(rows.astype(self.journals[name].base).tobytes() for rows in noted)
            for name, noted in self._news.items()
        }
        self._news = {name: [] for name in self.journals}
        return found

    def restore(  # noqa: B027 (optional)
        self, arrays: Mapping[str, np.ndarray], journals: Mapping[str, np.ndarray]
    ) -> None:
        """Take back what `arrays` returned, and all rows of the journals."""

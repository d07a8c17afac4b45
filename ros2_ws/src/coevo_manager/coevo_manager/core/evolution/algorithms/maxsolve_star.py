"""An archive that loses members that others make needless (Maxsolve*, Nolfi and Pagliuca 2025)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithms.archive import ArchiveOfBest
from coevo_manager.core.evolution.archive import Archive
from coevo_manager.core.evolution.matchup import Agents, Evolved, Opponents
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.record import Record
from coevo_manager.core.evolution.state import State, fitness_of
from coevo_manager.core.species import OTHER, SPECIES
from marxbot_sim.core.fields import Option

TRIED = 10
"""Members, chosen at random, of which at most one leaves."""

USE = np.dtype((np.int64, (4,)))
"""A row of the journal of uses: period, member, pairs played, fitness summed over them, ticks."""


class MaxsolveStar(ArchiveOfBest):
    """Every centre enters the archive; beyond a size, members that are dominated leave.

    Members are judged by what they achieve as opponents, in each of the latest periods of time.
    One is dominated where another is as good or better in all of them (after De Jong 2005). All
    candidates of a generation meet the same n different members.
    """

    defaults: ClassVar[Mapping[str, Any]] = {**ArchiveOfBest.defaults, 'openai_agent': 'centre'}
    parameters: ClassVar = (
        Option(
            'maxsolve_size', int, 1000, 'members beyond which one may leave', 'members', 1, 10**6
        ),
        Option(
            'maxsolve_periods', int, 10, 'latest periods in which members are judged',
            'periods', 1, 1000,
        ),
        Option(
            'maxsolve_period', int, 500, 'length of a period, in generations of a species',
            'generations', 1, 10**6,
        ),
    )  # fmt: skip
    journals: ClassVar[Mapping[str, np.dtype]] = {
        **ArchiveOfBest.journals,
        **{f'uses_{species}': USE for species in SPECIES},
        **{f'left_{species}': np.dtype(np.int64) for species in SPECIES},
    }

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self._records = {s: Record(configuration.maxsolve_periods) for s in SPECIES}

    @classmethod
    def check(cls, configuration: Configuration) -> None:
        """Demand that enough members stay to choose opponents from."""
        super().check(configuration)
        if configuration.maxsolve_size < configuration.selected:
            raise ValueError(
                f'maxsolve_size is {configuration.maxsolve_size}, expected at least selected, '
                f'{configuration.selected}'
            )

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Draw different members in each generation, the same for all candidates."""
        archive = self._archives[OTHER[state.evolving]]
        size, phase, seed = len(archive), state.phase + 1, self.configuration.seed
        count = self.configuration.selected

        def draw(agent: int, generation: int, groups: int) -> np.ndarray:
            rng = generator(seed, 'drawn opponents', phase, agent, generation)
            members = rng.permutation(size)[:count]
            return np.broadcast_to(members, (groups, count))

        return Opponents(archive.genomes, draw=draw, met=count)

    def settle(
        self, state: State, agents: Agents, fitness: np.ndarray | None, evolved: Evolved
    ) -> int:
        """Note how members did as opponents, let the centres enter and dominated members go."""
        del agents, fitness
        species, other = state.evolving, OTHER[state.evolving]
        (meetings,) = evolved.meetings
        for generation, meeting in enumerate(meetings):
            period = self._records[species].entered // self.configuration.maxsolve_period
            achieved = fitness_of(other, meeting.capture_ticks, state.pair_ticks)
            uses = self._records[other].use(
                period, meeting.opponents[0], len(achieved), achieved.sum(axis=0, dtype=np.int64)
            )
            self.note(f'uses_{other}', uses)
            self.enter(species, meeting.genome[np.newaxis])
            self._records[species].enter(1)
            rng = generator(self.configuration.seed, 'leaving', state.phase + 1, generation)
            self._leave(species, rng)
        return self.take_places(state, evolved)

    def _leave(self, species: str, rng: np.random.Generator) -> None:
        """Let one member go, if there are too many and one of those tried is dominated."""
        record, place = self._records[species], -1
        if len(self._archives[species]) > self.configuration.maxsolve_size:
            place = record.dominated(rng, TRIED)
        self.note(f'left_{species}', np.array([place]))
        if place >= 0:
            self._archives[species].remove(place)
            record.remove(place)

    def remember(self, state: State, species: str) -> None:
        """Begin with the first population."""
        super().remember(state, species)
        if not len(self._records[species]):
            self._records[species].begin(len(self._archives[species]))

    def restore(
        self, arrays: Mapping[str, np.ndarray], journals: Mapping[str, np.ndarray]
    ) -> None:
        """Take back the archives, without those that left, and what members achieved."""
        super().restore(arrays, journals)
        first = self.configuration.population
        for species in SPECIES:
            left, uses = journals[f'left_{species}'], journals[f'uses_{species}']
            everyone = self._archives[species].genomes
            if len(left) != len(everyone) - first:
                raise ValueError(
                    f'left_{species} has {len(left)} rows, expected {len(everyone) - first}'
                )
            record = Record.of(self.configuration.maxsolve_periods, first, left, uses)
            self._records[species] = record
            self._archives[species] = Archive.of(
                everyone[record.members], f'archive_{species}', self.configuration.layout
            )

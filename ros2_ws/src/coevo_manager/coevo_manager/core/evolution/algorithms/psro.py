"""Policy-space response oracles (PSRO, Lanctot et al. 2017)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm
from coevo_manager.core.evolution.archive import GENES, Archive
from coevo_manager.core.evolution.matchup import Agents, Evolved, Opponents
from coevo_manager.core.evolution.meta_strategy import SOLVERS, systematic_sample
from coevo_manager.core.evolution.state import State, fitness_of
from coevo_manager.core.species import OTHER, SPECIES
from marxbot_sim.core.fields import Option


class Psro(Algorithm):
    """A growing population; each new member answers the opponents' optimal mixture of theirs.

    The results of all members against all are a zero-sum game between the species, whose optimal
    mixtures are the meta-strategies. The n opponents of a phase are a sample of the opposing
    meta-strategy, and the n agents are the members that do best against it; of them, evolved, the
    one that does best against it joins. The newest N members are what snapshots show.
    """

    defaults: ClassVar[Mapping[str, Any]] = {
        'population': 10,
        'swap_generations': 100,
    }
    parameters: ClassVar = (
        Option(
            'psro_solver',
            str,
            'linear_programming',
            'how the meta-strategies are found',
            choices=tuple(SOLVERS),
        ),
    )
    journals: ClassVar[Mapping[str, np.dtype]] = {
        **{f'members_{species}': GENES for species in SPECIES},
        'results': np.dtype(np.int32),
    }

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self._members = {species: Archive(configuration.layout) for species in SPECIES}
        self._ticks = np.empty((0, 0), np.int32)
        self._mixture = np.empty(0)

    @staticmethod
    def default_selected(population: int) -> int:
        """Return the size of the first population."""
        return population

    def rivals(self, state: State) -> np.ndarray:
        """Return all opposing members."""
        return self._members[OTHER[state.evolving]].genomes

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Sample the opposing meta-strategy."""
        opposing = fitness_of(OTHER[state.evolving], self._results(state), state.pair_ticks).T
        self._mixture = SOLVERS[self.configuration.psro_solver](opposing / state.pair_ticks)
        self._drawn = systematic_sample(self._mixture, self.configuration.selected, rng)
        return Opponents(self.rivals(state)[self._drawn])

    def start(self, state: State, fitness: np.ndarray | None, rng: np.random.Generator) -> Agents:
        """Take those members that do best against the opposing meta-strategy."""
        del rng
        fitness = fitness_of(state.evolving, self._results(state), state.pair_ticks)
        values = fitness @ self._mixture
        best = np.argsort(-values, kind='stable')[: self.configuration.selected]
        training = fitness[np.ix_(best, self._drawn)].sum(axis=1, dtype=np.int64)
        memory = np.zeros((len(best), state.memory[state.evolving].shape[1]))
        return Agents(self._members[state.evolving].genomes[best], training, memory)

    def settle(
        self, state: State, agents: Agents, fitness: np.ndarray | None, evolved: Evolved
    ) -> int:
        """Let the best response join, in the oldest place of the population."""
        del agents, fitness
        species, size = state.evolving, self.configuration.population
        values = fitness_of(species, evolved.capture_ticks, state.pair_ticks) @ self._mixture
        best = [int(values.argmax())]
        place = len(self._members[species]) % size
        opposing = len(self._members[OTHER[species]])
        newest = opposing - 1 - (opposing - 1 - np.arange(size)) % size
        state.replace(
            np.array([place]),
            evolved.genomes[best],
            evolved.capture_ticks[best][:, newest],
            evolved.memory[best],
        )
        self._join(species, evolved.genomes[best], evolved.capture_ticks[best])
        return 1

    def _results(self, state: State) -> np.ndarray:
        """Return the capture ticks of all members, row = the evolving species."""
        return self._ticks if state.evolving == 'predator' else self._ticks.T

    def _join(self, species: str, genomes: np.ndarray, ticks: np.ndarray) -> None:
        self._members[species].add(genomes)
        self.note(f'members_{species}', genomes)
        self.note('results', np.concatenate(([SPECIES.index(species)], ticks.ravel())))
        self._extend(species, ticks)

    def _extend(self, species: str, ticks: np.ndarray) -> None:
        if species == 'predator':
            self._ticks = np.concatenate((self._ticks, ticks))
        else:
            self._ticks = np.concatenate((self._ticks, ticks.T), axis=1)

    def remember(self, state: State, species: str) -> None:
        """Begin with the first populations."""
        if not len(self._members[species]):
            self._members[species].add(state.genomes(species))
            self.note(f'members_{species}', state.genomes(species))
            if species == SPECIES[-1]:
                self._ticks = state.capture_ticks.copy()
                self.note('results', self._ticks.ravel())

    def restore(
        self, arrays: Mapping[str, np.ndarray], journals: Mapping[str, np.ndarray]
    ) -> None:
        """Take back all members and their results."""
        del arrays
        for species in SPECIES:
            name = f'members_{species}'
            self._members[species] = Archive.of(journals[name], name, self.configuration.layout)
        size, results = self.configuration.population, journals['results']
        self._ticks = results[: size * size].reshape(size, size)
        place = size * size
        while place < len(results):
            species = SPECIES[results[place]]
            met = self._ticks.shape[1 if species == 'predator' else 0]
            self._extend(species, results[place + 1 : place + 1 + met].reshape(1, met))
            place += 1 + met
        sizes = tuple(len(self._members[species]) for species in SPECIES)
        if self._ticks.shape != sizes:
            raise ValueError(f'results are of {self._ticks.shape}, expected {sizes}')

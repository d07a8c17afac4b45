"""A lineage that meets ever new samples of an archive of the past (Nolfi and Pagliuca 2025)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution import optimizers
from coevo_manager.core.evolution.algorithm import Algorithm
from coevo_manager.core.evolution.archive import GENES, Archive
from coevo_manager.core.evolution.comparison import OPENAI_ES
from coevo_manager.core.evolution.matchup import Agents, Evolved, Opponents
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.genome import check_genomes


class ArchiveOfBest(Algorithm):
    """One lineage a species; its best sample of every phase is kept for good.

    In each generation each group of candidates, such as a mirrored pair, meets n members of the
    opposing archive, drawn uniformly with replacement. A lineage goes on from phase to phase with
    all it has learned. An archive begins with the random population; the population's places are
    then taken in turn by its newest members, and are what snapshots show.
    """

    defaults: ClassVar[Mapping[str, Any]] = {
        **OPENAI_ES,
        'openai_agent': 'latest',
        'population': 10,
        'generations': 10,
        'swap_generations': 10,
        'snapshot_generations': 100,
    }
    journals: ClassVar[Mapping[str, np.dtype]] = {f'archive_{s}': GENES for s in SPECIES}

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self._archives = {species: Archive(configuration.layout) for species in SPECIES}
        self._lineages: dict[str, np.ndarray] = {}
        self._memory: dict[str, np.ndarray] = {}
        self._entered = dict.fromkeys(SPECIES, 0)

    @staticmethod
    def default_selected(population: int) -> int:
        """Return the size of the first archive."""
        return population

    @classmethod
    def check(cls, configuration: Configuration) -> None:
        """Demand that all lineages begin, and that no agent is judged by former opponents."""
        lineages, name = cls.lineages(configuration), configuration.algorithm
        if configuration.population < lineages:
            raise ValueError(
                f'population is {configuration.population}, expected at least {lineages}, one for '
                f'each lineage, in the algorithm {name}'
            )
        optimizer = optimizers.load(configuration.optimizer)
        if optimizer.compares_generations(configuration) and not configuration.reevaluate_parents:
            raise ValueError(
                f'reevaluate_parents is False, expected True in the algorithm {name}, whose '
                f'opponents are new in each generation, with {configuration.optimizer}, which '
                'compares an agent with its parent'
            )

    @classmethod
    def lineages(cls, configuration: Configuration) -> int:
        """Count one."""
        del configuration
        return 1

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Let each group of candidates draw from the opposing archive in each generation."""
        archive = self._archives[OTHER[state.evolving]]
        size, phase, seed = len(archive), state.phase + 1, self.configuration.seed

        def draw(agent: int, generation: int, groups: int) -> np.ndarray:
            rng = generator(seed, 'drawn opponents', phase, agent, generation)
            return self.drawn(size, groups, rng)

        return Opponents(archive.genomes, draw=draw, met=self.configuration.selected)

    def drawn(self, size: int, groups: int, rng: np.random.Generator) -> np.ndarray:
        """Choose among the members of an archive of that size.

        Opponent c is of lineage c modulo their number. Lineages enter in turn, after the first
        population, whose members belong to them in turn too.

        Returns
        -------
        int64 (groups, n)
        """
        lineages, first = self.lineages(self.configuration), self.configuration.population
        lineage = np.arange(self.configuration.selected) % lineages
        begun = (first - lineage + lineages - 1) // lineages
        rounds = begun + (size - first) // lineages
        time = rng.integers(rounds, size=(groups, len(lineage)))
        later = first + (time - begun) * lineages + lineage
        return np.where(time < begun, time * lineages + lineage, later)

    def start(self, state: State, fitness: np.ndarray | None, rng: np.random.Generator) -> Agents:
        """Go on with the lineages."""
        del fitness, rng
        genomes, memory = self._lineages[state.evolving], self._memory[state.evolving]
        return Agents(genomes, np.zeros(len(genomes), np.int64), memory)

    def settle(
        self, state: State, agents: Agents, fitness: np.ndarray | None, evolved: Evolved
    ) -> int:
        """Let the agents enter the archive."""
        del agents, fitness
        self.enter(state.evolving, evolved.genomes)
        return self.take_places(state, evolved)

    def enter(self, species: str, genomes: np.ndarray) -> None:
        """Add members to an archive, float32 (k, genes)."""
        self._archives[species].add(genomes)
        self.note(f'archive_{species}', genomes)

    def take_places(self, state: State, evolved: Evolved) -> int:
        """Put the agents in the oldest places of the population; keep where lineages stand."""
        species, count = state.evolving, len(evolved.genomes)
        places = (self._entered[species] + np.arange(count)) % self.configuration.population
        state.replace(places, evolved.genomes, evolved.capture_ticks, evolved.memory)
        self._entered[species] += count
        self._lineages[species], self._memory[species] = evolved.positions, evolved.memory
        return count

    def remember(self, state: State, species: str) -> None:
        """Begin with the first population."""
        if species not in self._lineages:
            genomes = state.genomes(species)
            self.enter(species, genomes)
            self._lineages[species] = genomes[: self.lineages(self.configuration)].copy()
            self._memory[species] = state.memory[species][: len(self._lineages[species])].copy()

    def arrays(self) -> dict[str, np.ndarray]:
        """Return where the lineages stand, and how many have entered."""
        entered = np.array([self._entered[species] for species in SPECIES])
        return {
            'entered': entered,
            **{f'lineages_{species}': array for species, array in self._lineages.items()},
            **{f'memory_{species}': array for species, array in self._memory.items()},
        }

    def restore(
        self, arrays: Mapping[str, np.ndarray], journals: Mapping[str, np.ndarray]
    ) -> None:
        """Take back lineages and archives."""
        for species, entered in zip(SPECIES, arrays['entered'].tolist(), strict=True):
            name = f'lineages_{species}'
            self._lineages[species] = check_genomes(arrays[name], name, self.configuration.layout)
            self._memory[species] = arrays[f'memory_{species}']
            self._entered[species] = entered
            name = f'archive_{species}'
            self._archives[species] = Archive.of(journals[name], name, self.configuration.layout)

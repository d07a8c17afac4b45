"""The populations of a run and what is known of them."""

from __future__ import annotations

import dataclasses
from typing import TypeVar

import numpy as np

from coevo_manager.core.species import SPECIES

Ticks = TypeVar('Ticks', np.ndarray, int)


@dataclasses.dataclass
class State:
    """Both populations after a number of completed phases.

    Attributes
    ----------
    predators, prey : float32 (N, genes)
        Genomes.
    capture_ticks : int32 (N, N)
        Capture tick of each predator (row) against each prey (column), summed over the episodes of
        a pair, 1 to pair_ticks.
    pair_ticks : int
        Length of an episode, T, times the episodes of a pair.
    evolving : str
        Species that evolves in the next phase.
    phase, generation : int
        Completed phases and generations.
    episodes, ticks : int
        Cost so far.
    memory : dict of str to float64 (N, size)
        What the optimizers remember of each individual, by species.
    """

    predators: np.ndarray
    prey: np.ndarray
    capture_ticks: np.ndarray
    pair_ticks: int
    evolving: str = 'predator'
    phase: int = 0
    generation: int = 0
    episodes: int = 0
    ticks: int = 0
    memory: dict[str, np.ndarray] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.memory:
            self.memory = {species: np.zeros((len(self.prey), 0)) for species in SPECIES}

    def genomes(self, species: str) -> np.ndarray:
        """Return a species' genomes, float32 (N, genes)."""
        return self.predators if species == 'predator' else self.prey

    def fitness(self, species: str) -> np.ndarray:
        """Return a species' fitness against each opponent, in ticks.

        Returns
        -------
        int32 (N, N)
            Row = individual of the species, column = opponent; T - t for predators, t for prey.
        """
        return fitness_of(species, self._rows(species), self.pair_ticks)

    def mean_fitness(self, species: str) -> float:
        """Return a population's mean fitness over N x N, 0 to 1."""
        fitness = self.fitness(species)
        return int(fitness.sum(dtype=np.int64)) / (fitness.size * self.pair_ticks)

    def replace(
        self, places: np.ndarray, genomes: np.ndarray, ticks: np.ndarray, memory: np.ndarray
    ) -> None:
        """Put new individuals of the evolving species in places of old ones.

        Parameters
        ----------
        places : int (k,)
        genomes : float32 (k, genes)
        ticks : int32 (k, N)
            Their capture ticks against the opposing population.
        memory : float64 (k, size)
            What their optimizers remember.
        """
        self.memory[self.evolving][places] = memory
        self.genomes(self.evolving)[places] = genomes
        self._rows(self.evolving)[places] = ticks

    def _rows(self, species: str) -> np.ndarray:
        return self.capture_ticks if species == 'predator' else self.capture_ticks.T


def fitness_of(species: str, capture_ticks: Ticks, pair_ticks: int) -> Ticks:
    """Return fitness in ticks, of the shape of the capture ticks (or their sums)."""
    return pair_ticks - capture_ticks if species == 'predator' else capture_ticks

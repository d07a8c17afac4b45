"""Control: opponents from an archive of former champions (Rosin and Belew 1997)."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm, Contest, Opponents
from coevo_manager.core.evolution.selection import fittest
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.genome import check_genomes


class HallOfFame(Algorithm):
    """Part of the opponents is drawn from the champions of all former phases.

    After each phase the evolving species' fittest individual enters its hall of fame. The n
    opponents of a phase are a random sample of the opposing hall (``archive_share`` of them) and
    the fittest of the opposing population; agents are ranked on these opponents.
    """

    external_opponents = True

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self._halls: dict[str, list[np.ndarray]] = {species: [] for species in SPECIES}

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Sample the hall of fame without replacement; fill up with the fittest of today."""
        species = OTHER[state.evolving]
        hall = self._halls[species]
        wanted = round(self.configuration.archive_share * self.configuration.selected)
        drawn = rng.permutation(len(hall))[:wanted]
        fitness = state.fitness(species).sum(axis=1, dtype=np.int64)
        today = fittest(fitness, self.configuration.selected - len(drawn))
        champions = [hall[i] for i in drawn]
        return Opponents(np.array([*champions, *state.genomes(species)[today]]))

    def scores(self, contest: Contest) -> np.ndarray:
        """Sum fitness over the phase's opponents."""
        return contest.training

    def remember(self, state: State, species: str) -> None:
        """Add the species' champion to its hall of fame."""
        fitness = state.fitness(species).sum(axis=1, dtype=np.int64)
        self._halls[species].append(state.genomes(species)[fitness.argmax()].copy())

    def arrays(self) -> dict[str, np.ndarray]:
        """Return both halls, float32 (champions, 442)."""
        return {f'hall_{species}': np.array(hall) for species, hall in self._halls.items()}

    def restore(self, arrays: dict[str, np.ndarray]) -> None:
        """Take back both halls."""
        self._halls = {
            species: list(check_genomes(arrays[f'hall_{species}'], f'hall_{species}'))
            for species in SPECIES
        }

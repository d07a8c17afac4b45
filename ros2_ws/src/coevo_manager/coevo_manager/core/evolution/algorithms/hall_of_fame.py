"""Control: opponents from an archive of former champions (Rosin and Belew 1997)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm, Contest
from coevo_manager.core.evolution.archive import GENES, Archive
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.selection import fittest
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import OTHER, SPECIES
from marxbot_sim.core.fields import Option


class HallOfFame(Algorithm):
    """Part of the opponents is drawn from the champions of all former phases.

    After each phase the evolving species' fittest individual enters its hall of fame. The n
    opponents of a phase are a random sample of the opposing hall (``archive_share`` of them) and
    the fittest of the opposing population; agents are ranked on these opponents.
    """

    external_opponents = True
    journals: ClassVar = {f'hall_{species}': GENES for species in SPECIES}
    parameters: ClassVar = (
        Option(
            'archive_share',
            float,
            0.5,
            'share of the opponents drawn from the archive; the others, and those that a young '
            'archive lacks, are the fittest of the opposing population',
            minimum=0.0,
            maximum=1.0,
        ),
    )

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self._halls = {species: Archive(configuration.layout) for species in SPECIES}

    def opponents(self, state: State, rng: np.random.Generator) -> Opponents:
        """Sample the hall of fame without replacement; fill up with the fittest of today."""
        species = OTHER[state.evolving]
        hall = self._halls[species].genomes
        wanted = round(self.configuration.archive_share * self.configuration.selected)
        drawn = rng.permutation(len(hall))[:wanted]
        fitness = state.fitness(species).sum(axis=1, dtype=np.int64)
        today = fittest(fitness, self.configuration.selected - len(drawn))
        return Opponents(np.concatenate((hall[drawn], state.genomes(species)[today])))

    def scores(self, contest: Contest) -> np.ndarray:
        """Sum fitness over the phase's opponents."""
        return contest.training

    def remember(self, state: State, species: str) -> None:
        """Add the species' champion to its hall of fame."""
        fitness = state.fitness(species).sum(axis=1, dtype=np.int64)
        champion = state.genomes(species)[[fitness.argmax()]]
        self._halls[species].add(champion)
        self.note(f'hall_{species}', champion)

    def restore(
        self, arrays: Mapping[str, np.ndarray], journals: Mapping[str, np.ndarray]
    ) -> None:
        """Take back both halls."""
        self._halls = {
            species: Archive.of(journals[name], name, self.configuration.layout)
            for species, name in ((species, f'hall_{species}') for species in SPECIES)
        }

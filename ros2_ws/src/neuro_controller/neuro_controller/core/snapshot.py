"""Snapshots: both populations at one generation of a run, and who is the best of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neuro_controller.core.genome import Layout, check_genomes
from neuro_controller.core.reading import read_arrays, reading

SPECIES = ('predator', 'prey')


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Both populations at one generation.

    Attributes
    ----------
    generation : int
        0 where the file does not tell.
    predators, prey : float32 (n, genes), (m, genes)
    fitness : float64 (n, m)
        Of each predator (row) against each prey (column), from 0 to 1.
    """

    generation: int
    predators: np.ndarray
    prey: np.ndarray
    fitness: np.ndarray

    def population(self, species: str) -> np.ndarray:
        """Return the genomes of one species, in their places."""
        return self.predators if species == 'predator' else self.prey

    def ranking(self, species: str) -> np.ndarray:
        """Return the places of the individuals, from the best against this generation's opponents.

        Of equals, the lower place comes first.
        """
        own = self.fitness.mean(axis=1) if species == 'predator' else -self.fitness.mean(axis=0)
        return np.argsort(-own, kind='stable')

    def best(self, species: str, count: int) -> np.ndarray:
        """Return the genomes of the best `count` individuals, the champion first."""
        return self.population(species)[self.ranking(species)[:count]]


def read_snapshot(path: Path) -> Snapshot:
    """Read a snapshot from an npz file (docs/formats.md).

    Raises
    ------
    ReadingError
        The file is missing, damaged, or not such a file.

    Examples
    --------
    >>> import red_queen as rq
    >>> snapshot = rq.read_snapshot('runs/mine/snapshots/gen_000020.npz')
    >>> snapshot.best('prey', 2).shape
    (2, 442)
    """
    arrays = read_arrays(path, ('predators', 'prey', 'fitness'))
    with reading(path):
        predators = check_genomes(arrays['predators'], 'predators')
        prey = check_genomes(arrays['prey'], 'prey', Layout.of(predators.shape[1]))
        fitness = np.asarray(arrays['fitness'], np.float64)
        shape = (len(predators), len(prey))
        if fitness.shape != shape or 0 in shape or not ((fitness >= 0) & (fitness <= 1)).all():
            raise ValueError(
                f'fitness has shape {fitness.shape}, expected {shape} numbers from 0 to 1'
            )
        return Snapshot(int(arrays.get('generation', 0)), predators, prey, fitness)


def snapshots(run: Path | str) -> dict[int, Path]:
    """Return the snapshots of a run, by generation, in order.

    Parameters
    ----------
    run : Path or str
        A run folder; or one snapshot, which then counts as generation 0.

    Raises
    ------
    ValueError
        There are none, or the path is none that can be looked up.
    """
    run = Path(run)
    with reading(run):
        is_file, is_folder = run.is_file(), run.is_dir()
    if is_file:
        return {0: run}
    if not is_folder:
        raise ValueError(f'{run} does not exist, expected a run folder or a snapshot')
    found = {
        int(path.stem.removeprefix('gen_')): path
        for path in (run / 'snapshots').glob('gen_*.npz')
        if path.stem.removeprefix('gen_').isdecimal()
    }
    if not found:
        raise ValueError(f'{run} holds no snapshots/gen_*.npz, expected a run folder')
    return dict(sorted(found.items()))

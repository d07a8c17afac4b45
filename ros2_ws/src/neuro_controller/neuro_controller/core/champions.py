"""Champions: those that users name, and those that are shipped."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neuro_controller.core.genome import check_genomes
from neuro_controller.core.origin import Origin, read_origin
from neuro_controller.core.snapshot import read_snapshot, snapshots

SHIPPED = Path(__file__).resolve().parent.parent / 'champions'
"""Folder of the champions that come with this package, one file an environment."""


@dataclass(frozen=True, eq=False)
class Champion:
    """A genome, and where it comes from.

    Attributes
    ----------
    genome : float32 array, shape (genes,)
    species : str
        'predator' or 'prey'.
    rank : int
        In its population, from 0.
    origin : Origin
    """

    genome: np.ndarray
    species: str
    rank: int
    origin: Origin

    @property
    def settings(self):
        """The parameters of `Controller`, by name, that it evolved with."""
        return self.origin.settings(self.species)

    def __str__(self):
        return f'{self.species} of rank {self.rank} in {self.origin}'


def select_champion(text, species):
    """Return the champion that a user names.

    Parameters
    ----------
    text : str
        ``RUN[:GENERATION[:RANK]]``: a run folder or snapshot, the generation (default: the last)
        and the individual's rank in it (default: 0, the champion). ``shipped/NAME`` names a
        snapshot that comes with this package.
    species : str
        'predator' or 'prey'.

    Returns
    -------
    Champion

    Raises
    ------
    ValueError
        There is no such genome, or nothing tells how it evolved.

    Examples
    --------
    >>> import red_queen as rq
    >>> champion = rq.select_champion('shipped/open', 'predator')
    >>> champion.species, champion.rank
    ('predator', 0)
    """
    run, *rest = text.split(':')
    if len(rest) > 2 or not all(part.isdecimal() for part in rest):
        raise ValueError(
            f'{species} is {text!r}, expected RUN, RUN:GENERATION or RUN:GENERATION:RANK'
        )
    if run.startswith('shipped/'):
        run = SHIPPED / f'{run.removeprefix("shipped/")}.npz'
    found = snapshots(run)
    generation = int(rest[0]) if rest else max(found)
    if generation not in found:
        raise ValueError(
            f'{run} has no snapshot of generation {generation}, only of '
            f'{", ".join(map(str, found))}'
        )
    snapshot = read_snapshot(found[generation])
    ranking = snapshot.ranking(species)
    rank = int(rest[1]) if len(rest) > 1 else 0
    if rank >= len(ranking):
        raise ValueError(f'{species} rank is {rank}, expected 0 to {len(ranking) - 1}')
    genome = snapshot.population(species)[ranking[rank]]
    origin = read_origin(found[generation])
    check_genomes(genome[np.newaxis], f'{species} of {found[generation]}', origin.layout)
    return Champion(genome, species, rank, origin)

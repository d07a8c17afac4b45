"""Champions of evolutionary runs, read from their snapshots."""

import zipfile
from pathlib import Path

import numpy as np

from neuro_controller.core.genome import check_genomes

SPECIES = ('predator', 'prey')

SHIPPED = Path(__file__).resolve().parent.parent / 'champions'
"""Folder of the champions that come with this package, one file an environment."""


def read_snapshot(path):
    """Return the genomes of a snapshot, each species best first.

    Parameters
    ----------
    path : pathlib.Path
        A npz file with `predators` and `prey`, ``(n, 442)``, and `fitness`, ``(n, m)``: that of
        each predator (row) against each prey (column), from 0 to 1.

    Returns
    -------
    dict
        Species -> float32 array of shape (n, 442).

    Raises
    ------
    ValueError
        The file is missing, or not such a file.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            genomes = {
                'predator': check_genomes(arrays['predators'], 'predators'),
                'prey': check_genomes(arrays['prey'], 'prey'),
            }
            fitness = np.asarray(arrays['fitness'], np.float64)
    except FileNotFoundError:
        raise ValueError(f'{path} does not exist') from None
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise ValueError(f'{path} is not a snapshot: {error}') from None
    shape = (len(genomes['predator']), len(genomes['prey']))
    if fitness.shape != shape or 0 in shape or not np.isfinite(fitness).all():
        raise ValueError(
            f'{path} is not a snapshot: fitness has shape {fitness.shape}, expected {shape}'
        )
    return {
        'predator': genomes['predator'][np.argsort(-fitness.mean(axis=1), kind='stable')],
        'prey': genomes['prey'][np.argsort(fitness.mean(axis=0), kind='stable')],
    }


def snapshots(run):
    """Return the snapshots of a run, by generation.

    Parameters
    ----------
    run : pathlib.Path
        A run folder; or one snapshot, which then counts as generation 0.

    Returns
    -------
    dict
        Generation -> path, in order.

    Raises
    ------
    ValueError
        There are none.
    """
    run = Path(run)
    if run.is_file():
        return {0: run}
    if not run.is_dir():
        raise ValueError(f'{run} does not exist, expected a run folder or a snapshot')
    found = {
        int(path.stem.removeprefix('gen_')): path
        for path in (run / 'snapshots').glob('gen_*.npz')
        if path.stem.removeprefix('gen_').isdecimal()
    }
    if not found:
        raise ValueError(f'{run} holds no snapshots/gen_*.npz, expected a run folder')
    return dict(sorted(found.items()))


def select_genome(text, species):
    """Return the genome that a user names.

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
    float32 array, shape (442,)

    Raises
    ------
    ValueError
        There is no such genome.
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
    genomes = read_snapshot(found[generation])[species]
    rank = int(rest[1]) if len(rest) > 1 else 0
    if rank >= len(genomes):
        raise ValueError(f'{species} rank is {rank}, expected 0 to {len(genomes) - 1}')
    return genomes[rank]

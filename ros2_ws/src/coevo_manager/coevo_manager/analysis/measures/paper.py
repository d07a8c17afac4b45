"""The paper's measures of progress (sections 2.3 to 5) on arrays, without files or simulation.

A *tournament* holds predator fitness: `tournament[..., i, j]` is the mean fitness of the predators
of generation i against the prey of generation j, in [0, 1] (row = predator, column = prey). A
*performance* is the same in the agents' own terms: `performance[..., i, j]`, agents of generation
i against opponents of generation j. Leading axes are replications.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from coevo_manager.analysis.measures.statistics import ALPHA, compare_paired
from coevo_manager.core.species import SPECIES


def performance(tournament: ArrayLike, species: str) -> np.ndarray:
    """Fitness of one species' agents (rows) against the other's opponents (columns).

    The predators' is the tournament itself; the prey's is 1 minus its transpose (Fig. 3).
    """
    if species not in SPECIES:
        raise ValueError(f'species is {species!r}, expected predator or prey')
    tournament = np.asarray(tournament, float)
    return tournament if species == 'predator' else 1.0 - np.swapaxes(tournament, -1, -2)


def ciao(tournament: ArrayLike, species: str) -> np.ndarray:
    """Current individuals against ancestral opponents (Cliff & Miller): NaN above the diagonal."""
    table = performance(tournament, species).copy()
    size = table.shape[-1]
    table[..., np.arange(size)[:, None] < np.arange(size)] = np.nan
    return table


def historical_tests(tournaments: ArrayLike, generations: ArrayLike, species: str) -> pd.DataFrame:
    """Table 1: agents against opponents of earlier generations, compared with their own.

    Parameters
    ----------
    tournaments : array_like (R, S, S)
    generations : array_like (S,), ascending, starting with generation 0
    species : 'predator' or 'prey', the agents

    Returns
    -------
    pandas.DataFrame
        One row for each generation of agents and each earlier generation of opponents:
        `generation`, `earlier` and the columns of `compare_paired` (first: against the earlier
        opponents, second: against those of the agents' own generation).
    """
    own = performance(tournaments, species)
    later, earlier = np.tril_indices(own.shape[-1], -1)
    return _tests(own[:, later, earlier].T, own[:, later, later].T, generations, later, earlier)


def global_tests(tournaments: ArrayLike, generations: ArrayLike, species: str) -> pd.DataFrame:
    """Table 2: agents against the last generation's opponents, compared with earlier agents.

    As `historical_tests`, with first: the agents of `generation`, second: those of `earlier`, both
    against the opponents of the last generation.
    """
    return increase_tests(performance(tournaments, species)[:, :, -1], generations)


def increase_tests(values: ArrayLike, generations: ArrayLike) -> pd.DataFrame:
    """Is a quantity (R, S) larger at a generation than at an earlier one? For each such pair."""
    values = np.asarray(values, float)
    later, earlier = np.tril_indices(values.shape[-1], -1)
    return _tests(values[:, later].T, values[:, earlier].T, generations, later, earlier)


def most_recent(tests: pd.DataFrame, column: str = 'p_paper', alpha: float = ALPHA) -> pd.Series:
    """Reduce the tests to a column of Table 1 or 2.

    Returns
    -------
    pandas.Series
        For each generation above 0, the most recent earlier generation whose comparison is
        significant; 0 when none after generation 0 is, as in the paper. With one replication, NaN.
    """
    if tests[column].isna().all():
        return tests.groupby('generation')['earlier'].max().astype(float) * np.nan
    significant = tests['earlier'].where(tests[column] < alpha, 0)
    return significant.groupby(tests['generation']).max()


def duration(table: pd.Series) -> float:
    """Generations of progress: the last generation whose entry exceeds all entries before it.

    This is how the paper reads its tables (section 3): "progress continued until". 0 when no entry
    is above 0; NaN when nothing could be tested.
    """
    if table.isna().all():
        return np.nan
    rising = table[table > table.cummax().shift(fill_value=0)]
    return int(rising.index[-1]) if len(rising) else 0


def rate(tournament: ArrayLike, generations: ArrayLike, species: str, until: int) -> np.ndarray:
    """Performance gained per 1000 generations against earlier opponents (section 2.3).

    The gain is how much better the agents of generation `until` do than those of the first
    generation, both against the opponents of all generations before `until`.

    Parameters
    ----------
    tournament : array_like (..., S, S)
    until : int
        One of `generations`: the end of the period (normally the duration of progress).

    Returns
    -------
    ndarray (...)
        NaN when `until` is the first generation.
    """
    generations = np.asarray(generations)
    end = int(np.flatnonzero(generations == until)[0])
    own = performance(tournament, species)
    if end == 0:
        return np.full(own.shape[:-2], np.nan)
    gain = (own[..., end, :end] - own[..., 0, :end]).mean(axis=-1)
    return gain / (generations[end] - generations[0]) * 1000


def normalised(curve: ArrayLike) -> np.ndarray:
    """Scale a curve to [0, 1] by its own minimum and maximum (Fig. 9); a flat one becomes 0."""
    curve = np.asarray(curve, float)
    extent = np.ptp(curve)
    return (curve - curve.min()) / extent if extent > 0 else np.zeros_like(curve)


def representative(complexity: ArrayLike) -> list[tuple[int, int]]:
    """Episodes at the 0th, 25th, 50th, 75th and 100th percentile of complexity (Fig. 5).

    Parameters
    ----------
    complexity : array_like (P, Q), of one species over every predator (row) and prey (column)

    Returns
    -------
    list of (predator, prey), from the simplest to the most complex
    """
    complexity = np.asarray(complexity)
    order = np.argsort(complexity, axis=None, kind='stable')
    picks = order[np.round(np.linspace(0, len(order) - 1, 5)).astype(int)]
    return [(int(pick) // complexity.shape[1], int(pick) % complexity.shape[1]) for pick in picks]


def _tests(
    first: np.ndarray,
    second: np.ndarray,
    generations: ArrayLike,
    later: np.ndarray,
    earlier: np.ndarray,
) -> pd.DataFrame:
    generations = np.asarray(generations)
    tests = compare_paired(first, second)
    tests.insert(0, 'generation', generations[later])
    tests.insert(1, 'earlier', generations[earlier])
    return tests

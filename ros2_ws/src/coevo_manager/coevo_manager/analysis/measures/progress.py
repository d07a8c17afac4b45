"""Did they make progress? One number a replication, and what may be claimed of it."""

from __future__ import annotations

import numpy as np

from coevo_manager.analysis.measures import beyond, statistics


def halves(size: int) -> tuple[slice, slice]:
    """The first and the second half of S generations, generation 0 (random genomes) left out.

    Anything beats random genomes and is better than them: leaving them out keeps the take-off of
    the first generations from passing for lasting progress. Both halves are empty where S < 3.
    """
    middle = 1 + (size - 1) // 2
    return slice(1, middle), slice(middle, size if size > 2 else middle)


def historical_gain(own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How the second half's agents do against the first half's opponents, and their own.

    Parameters
    ----------
    own : array_like (R, S, S), `measures.performance`

    Returns
    -------
    ancestors, contemporaries : ndarray (R,)
        Mean performance of the agents of the second half against the opponents of the first half,
        and against those of their own generation. NaN where S < 3.
    """
    own = np.asarray(own, float)
    early, late = halves(own.shape[-1])
    contemporaries = np.diagonal(own, axis1=-2, axis2=-1)[:, late]
    return _mean(own[:, late, early].reshape(len(own), -1)), _mean(contemporaries)


def global_gain(curve: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How the second half's agents and the first half's do against the same opponents.

    Parameters
    ----------
    curve : array_like (R, S)
        Performance of each generation against one fixed set of opponents.

    Returns
    -------
    late, early : ndarray (R,)
    """
    curve = np.asarray(curve, float)
    early, late = halves(curve.shape[-1])
    return _mean(curve[:, late]), _mean(curve[:, early])


def cyclic_share(tournaments: np.ndarray) -> float:
    """Mean over replications (R, S, S) of the cyclic share, generation 0 left out."""
    shares = [beyond.hodge(tournament[1:, 1:])[2] for tournament in np.asarray(tournaments)]
    return float(np.nanmean(shares)) if np.isfinite(shares).any() else np.nan


def verdict(rise: float, fall: float, share: float, changed: bool = True) -> str:
    """Say what may be claimed.

    Parameters
    ----------
    rise, fall : float
        Corrected one-tailed p-values for a gain and for a loss; NaN without replications.
    share : float
        Cyclic share of the tournament.
    changed : bool
        Whether any replication gained or lost anything.

    Returns
    -------
    str
        'no change' where nothing changed, so that there is nothing to test, 'cannot be claimed'
        without replications, 'not significant', 'retrogression', 'progress', or 'cyclic': a gain
        where the tournament is more cyclic than transitive, so that it may be no more than the
        phase of a cycle in which the halves of the run happen to be.
    """
    if not changed:
        return 'no change'
    if np.isnan(rise):
        return 'cannot be claimed'
    if rise < statistics.ALPHA:
        return 'cyclic' if share > 0.5 else 'progress'
    return 'retrogression' if fall < statistics.ALPHA else 'not significant'


def _mean(values: np.ndarray) -> np.ndarray:
    return values.mean(axis=1) if values.shape[1] else np.full(len(values), np.nan)

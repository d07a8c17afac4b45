"""Measures beyond the paper's: retrogression, cyclicity and diversity, on arrays.

Orientation and names are those of `measures`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from coevo_manager.analysis.measures.paper import performance


def retrogression(tournament: ArrayLike, species: str) -> tuple[np.ndarray, np.ndarray]:
    """How often, and how much, a step between successive generations loses ground.

    Every step i -> i+1 is judged against every generation of opponents, earlier and later.

    Returns
    -------
    rate : ndarray (...)
        Fraction of (step, opponents) pairs in which performance falls. Steady progress: 0; change
        without direction: about 0.5.
    loss : ndarray (...)
        Sum of the falls over the sum of all changes, in absolute value. NaN when nothing changes.
    """
    change = np.diff(performance(tournament, species), axis=-2)
    falls = np.where(change < 0, -change, 0).sum(axis=(-2, -1))
    total = np.abs(change).sum(axis=(-2, -1))
    with np.errstate(invalid='ignore'):
        return (change < 0).mean(axis=(-2, -1)), falls / total


def hodge(tournament: ArrayLike) -> tuple[np.ndarray, np.ndarray, float]:
    """Split the game between generations into a transitive and a cyclic part.

    Each generation plays both roles against every other: `margin[i, j]` is the predator fitness of
    generation i's predators against j's prey less that of j's predators against i's prey, so that
    `margin` is antisymmetric and positive where generation i beats generation j. Its combinatorial
    Hodge decomposition (Jiang et al. 2011; Balduzzi et al. 2018) is margin[i, j] = rating[i] -
    rating[j] + cyclic[i, j]: progress lifts the ratings, rock-paper-scissors is all in the cyclic
    part.

    Parameters
    ----------
    tournament : array_like (S, S)

    Returns
    -------
    rating : ndarray (S,), mean 0, in units of fitness
    cyclic : ndarray (S, S), antisymmetric, rows sum to 0
    share : float
        Part of the margins' sum of squares that is cyclic, in [0, 1]; NaN when all margins are 0.
    """
    tournament = np.asarray(tournament, float)
    margin = tournament - tournament.T
    rating = margin.mean(axis=1)
    cyclic = margin - (rating[:, None] - rating[None, :])
    energy = (margin**2).sum()
    return rating, cyclic, float((cyclic**2).sum() / energy) if energy > 0 else np.nan


def path_diversity(paths: ArrayLike) -> float:
    """Mean distance between the paths of individuals that met the same opponent.

    Parameters
    ----------
    paths : array_like (n, k, 2), positions in m of n individuals at the same k moments

    Returns
    -------
    float
        Mean over pairs of individuals of their mean distance over time, m; NaN for fewer than two.
    """
    paths = np.asarray(paths, float)
    if len(paths) < 2:
        return np.nan
    first, second = np.triu_indices(len(paths), 1)
    return float(np.linalg.norm(paths[first] - paths[second], axis=-1).mean())


def profile_diversity(fitness: ArrayLike) -> float:
    """Mean Euclidean distance between the fitness profiles (rows) of a population, per opponent.

    The distance by which the generalist algorithm tells opponents apart (section 2.1), divided by
    the square root of their number: 0 for equal profiles, 1 for profiles that differ by 1
    everywhere.
    """
    fitness = np.asarray(fitness, float)
    if len(fitness) < 2:
        return np.nan
    first, second = np.triu_indices(len(fitness), 1)
    distance = np.linalg.norm(fitness[first] - fitness[second], axis=-1)
    return float(distance.mean() / np.sqrt(fitness.shape[1]))

"""Who stays at the end of a phase (Simione and Nolfi 2019, section 2.1)."""

from __future__ import annotations

import numpy as np


def opponent_weights(fitness: np.ndarray, pair_ticks: int) -> np.ndarray:
    """Sum each opponent's own fitness over the individuals it met.

    Parameters
    ----------
    fitness : int (individuals, N)
        Fitness of each individual against each opponent, in ticks.
    pair_ticks : int

    Returns
    -------
    int64 (N,)
        In ticks: the opponent's mean fitness times a constant, which does not change a ranking.
    """
    return (pair_ticks - fitness).sum(axis=0, dtype=np.int64)


def weighted_scores(fitness: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sum fitness against each opponent times that opponent's weight.

    The weighted ranking of Rosin and Belew (1997) as the paper uses it: an opponent weighs its
    own mean fitness, so that success against strong opponents counts for more.

    Parameters
    ----------
    fitness : int (individuals, N)
        Fitness of each individual against each opponent, in ticks.
    weights : int (N,)
        Weight of each opponent.

    Returns
    -------
    int64 (individuals,)
    """
    return fitness.astype(np.int64) @ weights.astype(np.int64)


def survivors(scores: np.ndarray, population: int) -> np.ndarray:
    """Rank N incumbents followed by n evolved agents; return the N that stay, best first.

    Among equal scores evolved agents come first, then the lowest index.

    Parameters
    ----------
    scores : (N + n,)
    population : int
        N.
    """
    index = np.arange(len(scores))
    return np.lexsort((index, index < population, -scores))[:population]


def replacements(scores: np.ndarray, population: int) -> tuple[np.ndarray, np.ndarray]:
    """Decide which evolved agents take which incumbents' places.

    Incumbents that stay keep their places; the retained evolved agents, best first, take the
    places of the dropped incumbents, worst first.

    Returns
    -------
    places, evolved : int64 (retained,), (retained,)
        Indices from 0 to N - 1, and from 0 to n - 1.
    """
    stay = survivors(scores, population)
    evolved = stay[stay >= population] - population
    dropped = np.setdiff1d(np.arange(population), stay)
    worst_first = dropped[np.lexsort((-dropped, scores[dropped]))]
    return worst_first, evolved

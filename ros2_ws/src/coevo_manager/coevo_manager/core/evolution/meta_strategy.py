"""Mixtures of the rows of a zero-sum game that do well against every column."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

REPLICATOR_STEPS = 20_000
"""Steps of the replicator dynamics; its mixture is their mean."""


def guarantee(fitness: np.ndarray) -> tuple[np.ndarray, float]:
    """Return a mixture of rows that guarantees the game's value, and that (von Neumann 1928).

    Parameters
    ----------
    fitness : float (n, m)
        Of each row against each column, 0 to 1; the columns have the rest.

    Returns
    -------
    mixture : float64 (n,)
        Probabilities.
    value : float
        What the mixture gets at least against any column.
    """
    from scipy.optimize import linprog  # here, since it takes long to load

    n, m = fitness.shape
    found = linprog(
        np.append(np.zeros(n), -1.0),
        A_ub=np.hstack((-fitness.T, np.ones((m, 1)))),
        b_ub=np.zeros(m),
        A_eq=[np.append(np.ones(n), 0.0)],
        b_eq=[1.0],
        bounds=[(0.0, 1.0)] * n + [(None, None)],
    )
    mixture = np.clip(found.x[:n], 0.0, None)
    return mixture / mixture.sum(), float(-found.fun)


def linear_programming(fitness: np.ndarray) -> np.ndarray:
    """Return the mixture of rows of `guarantee`, float64 (n,)."""
    return guarantee(fitness)[0]


def replicator(fitness: np.ndarray) -> np.ndarray:
    """Return the mean mixture of rows under replicator dynamics of both sides.

    Shares grow with what they gain over the mean (Taylor and Jonker 1978), by multiplicative
    weights with a step that falls as the square root of 8 ln n over the number of steps; the mean
    over time approaches an optimal mixture (Freund and Schapire 1999).

    Parameters
    ----------
    fitness : float (n, m)
        As in `guarantee`.

    Returns
    -------
    float64 (n,)
    """
    rows, columns = (np.zeros(size) for size in fitness.shape)
    rates = [np.sqrt(8 * np.log(max(size, 2)) / REPLICATOR_STEPS) for size in fitness.shape]
    total = np.zeros(len(fitness))
    for _ in range(REPLICATOR_STEPS):
        ours, theirs = _shares(rows), _shares(columns)
        total += ours
        rows += rates[0] * (fitness @ theirs)
        columns -= rates[1] * (ours @ fitness)
    return total / total.sum()


def _shares(weights: np.ndarray) -> np.ndarray:
    shares = np.exp(weights - weights.max())
    return shares / shares.sum()


SOLVERS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    'linear_programming': linear_programming,
    'replicator': replicator,
}


def systematic_sample(mixture: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Draw rows so that each is taken its expected number of times, rounded up or down.

    Parameters
    ----------
    mixture : float (n,)
        Probabilities.
    count : int
    rng : Generator

    Returns
    -------
    int64 (count,)
        In ascending order.
    """
    points = (np.arange(count) + rng.random()) / count
    ends = np.cumsum(mixture)
    return np.searchsorted(ends / ends[-1], points, side='right')

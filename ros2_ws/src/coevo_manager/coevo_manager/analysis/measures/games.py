"""What game theory says of a tournament: Nash averaging, alpha-rank, exploitability, diversity.

A tournament is a two-player zero-sum game in which a predator and a prey are chosen: row i,
column j of ``fitness`` is the mean fitness of predators i against prey j, 0 to 1, and the prey
have the rest. Rows and columns are generations, or whatever else was compared.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.optimize import linprog, minimize

from coevo_manager.core.evolution.meta_strategy import guarantee

ALPHA = 10.0
"""Selection intensity of `alpha_rank`: a twentieth more fitness makes a takeover e^24 times as
likely as its reverse, and the rarest takeover is still a float64."""

POPULATION = 50
"""Size of the populations of `alpha_rank` in which a mutant takes over, as in OpenSpiel."""

_FACE = 1e-9
"""How far below the game's value a strategy may stay that counts as optimal, against rounding."""

_RAREST = 1e-6
"""Least probability of a strategy that counts as used by an equilibrium."""


@dataclasses.dataclass(frozen=True)
class Equilibrium:
    """The Nash equilibrium of greatest entropy, and what it says of everyone.

    Attributes
    ----------
    value : float
        Fitness of the predators when both sides play it, 0 to 1.
    predators, prey : float64 (n,), (m,)
        Probabilities with which it plays each.
    predator_ratings, prey_ratings : float64 (n,), (m,)
        Each one's fitness against the other side's mixture, less the value (predators) or less one
        minus the value (prey): 0 for whom the equilibrium uses, below 0 for the others.
    """

    value: float
    predators: np.ndarray
    prey: np.ndarray
    predator_ratings: np.ndarray
    prey_ratings: np.ndarray


def nash_average(fitness: np.ndarray) -> Equilibrium:
    """Rate everyone against the equilibrium (Balduzzi et al. 2018, Re-evaluating evaluation).

    Where there is one equilibrium, no copy moves a rating: who is entered twice shares its
    probability.

    Parameters
    ----------
    fitness : array_like, shape (n, m)
    """
    fitness = np.asarray(fitness, float)
    _, value = guarantee(fitness)
    predators = _most_even(fitness, value)
    prey = _most_even(1.0 - fitness.T, 1.0 - value)
    return Equilibrium(value, predators, prey, fitness @ prey - value, value - predators @ fitness)


def alpha_rank(
    fitness: np.ndarray, alpha: float = ALPHA, population: int = POPULATION
) -> np.ndarray:
    """Return how long evolution stays with each pair (Omidshafiei et al. 2019, alpha-Rank).

    Two finite populations, each of one kind at a time, are invaded by single mutants that take
    over with the fixation probability of the Moran process. The stationary distribution of that
    Markov chain survives cycles, where a ranking has no answer.

    Parameters
    ----------
    fitness : array_like, shape (n, m)
    alpha : float
        Selection intensity, above 0.
    population : int
        Individuals in each population, at least 2.

    Returns
    -------
    float64 (n, m)
        Share of time of each pair of predators and prey; the sum is 1.
    """
    fitness = np.asarray(fitness, float)
    n, m = fitness.shape
    if n == m == 1:
        return np.ones((1, 1))
    chain = np.zeros((n, m, n, m))
    rows, columns = np.arange(n), np.arange(m)
    for j in columns:
        gain = fitness[np.newaxis, :, j] - fitness[:, np.newaxis, j]
        chain[:, j, :, j] += _fixation(gain, alpha, population)
    for i in rows:
        gain = fitness[i, :, np.newaxis] - fitness[i, np.newaxis, :]
        chain[i, :, i, :] += _fixation(gain, alpha, population)
    chain = chain.reshape(n * m, n * m) / (n + m - 2)
    np.fill_diagonal(chain, 0.0)
    return _stationary(chain).reshape(n, m)


def exploitability(fitness: np.ndarray) -> np.ndarray:
    """Return what the best other choices would gain against each generation, both sides added.

    Parameters
    ----------
    fitness : array_like, shape (n, n)
        Generations of both species in the same order.

    Returns
    -------
    float64 (n,)
        For predators and prey of one generation: the fitness that the best predators gain over
        these against these prey, plus what the best prey gain against these predators (NashConv of
        the pair in the game of the tournament); 0 where nobody does better, at most 1.
    """
    fitness = np.asarray(fitness, float)
    return fitness.max(axis=0) - fitness.min(axis=1)


def antisymmetric(fitness: np.ndarray) -> np.ndarray:
    """Return the game between generations: each plays both its species against the other's.

    Parameters
    ----------
    fitness : array_like, shape (n, n)

    Returns
    -------
    float64 (n, n)
        Row a, column b: fitness of predators of a against prey of b, less that of predators of b
        against prey of a.
    """
    fitness = np.asarray(fitness, float)
    return fitness - fitness.T


def effective_diversity(fitness: np.ndarray) -> float:
    """Return the effective diversity of the generations (Balduzzi et al. 2019).

    p' max(A, 0) p with the game A between generations and its equilibrium p: 0 where one
    generation beats all others, large where several are needed because they beat each other in
    turn.

    Parameters
    ----------
    fitness : array_like, shape (n, n)
    """
    game = antisymmetric(fitness)
    mixture = _most_even((game + 1.0) / 2.0, 0.5)
    return float(mixture @ np.maximum(game, 0.0) @ mixture)


def effective_number(probabilities: np.ndarray) -> float:
    """Return how many equally likely choices are as uncertain as these: e to their entropy."""
    used = probabilities[probabilities > 0.0]
    return float(np.exp(-(used * np.log(used)).sum()))


def _most_even(fitness: np.ndarray, value: float) -> np.ndarray:
    """Return the optimal mixture of rows that has the greatest entropy.

    Optimal mixtures p guarantee the value: p' fitness >= value in each column. The one of greatest
    entropy is exp(fitness @ prices), normalised, over the rows that any optimal mixture uses, with
    the prices >= 0 that minimise the convex dual.
    """
    used = np.flatnonzero(_used(fitness, value))
    payoff = fitness[used] - value

    def dual(prices: np.ndarray) -> tuple[float, np.ndarray]:
        weights = payoff @ prices
        highest = weights.max()
        shares = np.exp(weights - highest)
        total = shares.sum()
        return highest + np.log(total), shares / total @ payoff

    found = minimize(
        dual,
        np.zeros(fitness.shape[1]),
        jac=True,
        method='L-BFGS-B',
        bounds=[(0.0, None)] * fitness.shape[1],
        options={'maxiter': 10_000, 'ftol': 1e-15, 'gtol': 1e-10},
    )
    weights = payoff @ found.x
    mixture = np.zeros(len(fitness))
    mixture[used] = np.exp(weights - weights.max())
    return mixture / mixture.sum()


def _used(fitness: np.ndarray, value: float) -> np.ndarray:
    """Return which rows some optimal mixture uses, bool (n,).

    One linear program finds all: the greatest sum of u, each from 0 to 1, with u <= x, where x is
    an optimal mixture times any factor up to 1 / _RAREST.
    """
    n, m = fitness.shape
    zeros, unit = np.zeros((m, n)), np.eye(n)
    found = linprog(
        np.concatenate((np.zeros(n), -np.ones(n))),
        A_ub=np.vstack(
            (
                np.hstack((value - _FACE - fitness.T, zeros)),
                np.hstack((-unit, unit)),
                np.append(np.ones(n), np.zeros(n)),
            )
        ),
        b_ub=np.append(np.zeros(m + n), 1.0 / _RAREST),
        bounds=[(0.0, None)] * n + [(0.0, 1.0)] * n,
    )
    return found.x[n:] > 0.5


def _fixation(gain: np.ndarray, alpha: float, population: int) -> np.ndarray:
    """Return the probability that a mutant with this gain in fitness takes over a population."""
    neutral = np.abs(gain) < 1e-12
    pressure = alpha * np.where(neutral, 1.0, gain)
    with np.errstate(over='ignore'):
        return np.where(
            neutral, 1.0 / population, np.expm1(-pressure) / np.expm1(-population * pressure)
        )


def _stationary(chain: np.ndarray) -> np.ndarray:
    """Return the stationary distribution of an irreducible chain.

    Grassmann, Taksar and Heyman (1985) eliminate states without a subtraction, so that
    probabilities of any size keep their accuracy. The diagonal is not used.
    """
    chain = chain.copy()
    for last in range(len(chain) - 1, 0, -1):
        chain[:last, last] /= chain[last, :last].sum()
        chain[:last, :last] += np.outer(chain[:last, last], chain[last, :last])
    share = np.ones(len(chain))
    for state in range(1, len(chain)):
        share[state] = share[:state] @ chain[:state, state]
        share[: state + 1] /= share[: state + 1].sum()
    return share

"""Opponents and agents of a phase (Simione and Nolfi 2019, section 2.1).

Fitness is an integer throughout: the ticks of each episode that count for the individual, from 0
to the length of an episode. Sums and comparisons are therefore exact, and ties are real ties;
they fall to the lowest index.
"""

from __future__ import annotations

import numpy as np


def cluster(vectors: np.ndarray, groups: int) -> np.ndarray:
    """Merge individuals into groups of equal size, the most similar first.

    Each of log2(N / groups) rounds pairs all groups: the two nearest ones are merged, then the
    two nearest of the others, until none is left. The distance is the Euclidean one between
    centroids; among equal ones the pair with the lowest indices is merged first.

    Parameters
    ----------
    vectors : int (N, D)
        What is known of each individual: its fitness against each of D opponents.
    groups : int
        N / groups is a power of two.

    Returns
    -------
    int64 (groups, N / groups)
        Members of each group in ascending order, groups in the order of their first members.
    """
    members = np.arange(len(vectors))[:, None]
    sums = vectors.astype(np.float64)  # of integers: exact, sums of products are below 2**53
    while len(members) > groups:
        left, right = _nearest_pairs(sums)
        members = np.sort(np.concatenate((members[left], members[right]), axis=1), axis=1)
        sums = sums[left] + sums[right]
    return members


def _nearest_pairs(sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pair the rows, the nearest first; return the pairs in the order of their lower rows.

    Groups of a round are of equal size, so that the distances of their sums order as those of
    their centroids do.
    """
    count = len(sums)
    product = np.einsum('id,jd->ij', sums, sums)  # one thread, where BLAS would take two
    squares = np.diagonal(product)
    distance = squares[:, np.newaxis] + squares - 2 * product
    distance[np.tril_indices(count)] = np.inf
    pairs = []
    for _ in range(count // 2):
        i, j = divmod(int(distance.argmin()), count)
        distance[i] = distance[j] = np.inf
        distance[:, i] = distance[:, j] = np.inf
        pairs.append((i, j))
    pairs.sort()
    first, second = np.array(pairs).T
    return first, second


def fittest_of_groups(members: np.ndarray, fitness: np.ndarray) -> np.ndarray:
    """Choose the fittest individual of each group.

    Parameters
    ----------
    members : int (groups, size)
    fitness : int (N,)

    Returns
    -------
    int64 (groups,)
    """
    return members[np.arange(len(members)), fitness[members].argmax(axis=1)]


def fittest(fitness: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of the ``count`` fittest, best first."""
    return np.argsort(-fitness, kind='stable')[:count]


def best_against_each(fitness: np.ndarray, distinct: bool) -> np.ndarray:
    """Choose for each opponent in turn the agent that is fittest against it.

    Parameters
    ----------
    fitness : int (N, opponents)
        Fitness of each agent against each opponent.
    distinct : bool
        An agent is taken once; where the best is taken, the next best is.

    Returns
    -------
    int64 (opponents,)
    """
    if not distinct:
        return fitness.argmax(axis=0)
    remaining = fitness.astype(np.int64)
    agents = np.empty(fitness.shape[1], np.int64)
    for opponent in range(len(agents)):
        agents[opponent] = remaining[:, opponent].argmax()
        remaining[agents[opponent]] = -1
    return agents

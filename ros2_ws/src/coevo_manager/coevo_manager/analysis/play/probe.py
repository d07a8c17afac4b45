"""How well can a fresh opponent do against a frozen champion? A search with a stated budget.

Post-evaluation shows performance against opponents somebody already found. A champion may still
have a weakness that no opponent in any run has met: the probe looks for it with (1+1) searches
(the paper's mutation: 2 % of the genes redrawn) that start from random genomes and play against
that champion only. The fitness they reach is a lower bound on the champion's exploitability.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.play.tournament import Evaluations, content_hash
from coevo_manager.core.episodes import Environment

GENE_LIMIT = 5.0
MUTATION_RATE = 0.02
WINS = 0.5
"""Fitness from which an opponent has the better of a champion."""


@dataclass(frozen=True)
class SearchBudget:
    """What a probe may spend on one champion.

    Attributes
    ----------
    candidates : int
        Genomes tried in each search, one episode each.
    searches : int
        Independent searches; the best opponent of all counts.
    """

    candidates: int = 500
    searches: int = 8


def best_response(
    kernel: Kernel,
    champion: np.ndarray,
    species: str,
    environment: Environment,
    budget: SearchBudget,
) -> np.ndarray:
    """Search opponents of a frozen champion.

    Every champion meets the same first genomes and the same mutations, so that champions differ in
    nothing but how well they stand up to them.

    Parameters
    ----------
    champion : float32 (genes,)
    species : 'predator' or 'prey'
        The champion's; the opponents searched for are the other's.

    Returns
    -------
    float32 (searches, candidates)
        Fitness of the best opponent of each search so far, over the candidates tried.
    """
    rng = np.random.default_rng(0)
    shape = budget.searches, champion.size
    candidates = rng.uniform(-GENE_LIMIT, GENE_LIMIT, shape).astype(np.float32)
    parents, fitness = candidates.copy(), np.full(budget.searches, -np.inf)
    history = np.empty((budget.searches, budget.candidates), np.float32)
    first, every = np.zeros(budget.searches, int), np.arange(budget.searches)
    for k in range(budget.candidates):
        if species == 'predator':
            ticks = kernel.ticks(champion[None], candidates, first, every, environment)
            found = ticks / environment.episode_ticks
        else:
            ticks = kernel.ticks(candidates, champion[None], every, first, environment)
            found = 1.0 - ticks / environment.episode_ticks
        better = found >= fitness
        parents[better], fitness[better] = candidates[better], found[better]
        history[:, k] = fitness
        redrawn = rng.random(shape) < MUTATION_RATE
        values = rng.uniform(-GENE_LIMIT, GENE_LIMIT, shape).astype(np.float32)
        candidates = np.where(redrawn, values, parents)
    return history


def best_found(history: np.ndarray) -> np.ndarray:
    """Fitness of the best opponent of all searches (..., searches, candidates) at their end."""
    return history[..., -1].max(axis=-1)


def candidates_needed(history: np.ndarray, level: float = WINS) -> np.ndarray:
    """Candidates tried until one scores `level`, mean over searches; the budget where none does.

    It tells champions apart that all fall in the end: the harder one takes longer to beat.
    """
    reached = history >= level
    first = np.where(reached.any(axis=-1), reached.argmax(axis=-1) + 1, history.shape[-1])
    return first.mean(axis=-1)


def while_searching(history: np.ndarray) -> np.ndarray:
    """Best fitness so far, averaged over the candidates tried and the searches.

    It tells champions apart that all fall in the end: the harder one is beaten later.
    """
    return history.mean(axis=(-2, -1))


def probe(
    evaluations: Evaluations,
    champions: Sequence[np.ndarray],
    species: str,
    environment: Environment,
    budget: SearchBudget,
    advance: Callable[[int], object] = lambda champions: None,
) -> np.ndarray:
    """`best_response` to each of k champions, through the store and on all cores.

    Returns
    -------
    float32 (k, searches, candidates)
    """
    jobs = []
    for champion in champions:
        digest = content_hash('probe', species, asdict(environment), asdict(budget), champion)
        jobs.append((digest, (champion, species, environment, budget)))
    return np.stack(evaluations.compute(best_response, jobs, advance=advance))

"""Mutations of a (1+1) lineage, drawn for many generations at once.

A mutation does not depend on any outcome, so that drawing a block of them costs little per
generation and gives the numbers that drawing them one by one would have given.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import numpy as np

BLOCK = 128
"""Generations drawn at once; part of what a seed means."""

Mutation = tuple[np.ndarray, np.ndarray]
"""Indices of the redrawn genes, int64 (k,), and their values, float32 (k,)."""


def bernoulli(genes: int, rate: float, rng: np.random.Generator) -> list[np.ndarray]:
    """Genes of each of BLOCK mutations, each gene with probability ``rate``."""
    places = np.flatnonzero(rng.random((BLOCK, genes), dtype=np.float32) < rate)
    ends = np.searchsorted(places, np.arange(1, BLOCK + 1) * genes)
    return _split(places % genes, ends)


def exact(genes: int, rate: float, rng: np.random.Generator) -> list[np.ndarray]:
    """Genes of each of BLOCK mutations, exactly round(rate * genes) different ones."""
    count = round(rate * genes)
    order = np.argsort(rng.random((BLOCK, genes), dtype=np.float32), axis=1)
    return list(np.sort(order[:, :count], axis=1))


KINDS: dict[str, Callable[[int, float, np.random.Generator], list[np.ndarray]]] = {
    'bernoulli': bernoulli,
    'exact': exact,
}


def draw_mutations(
    kind: str, genes: int, rate: float, limit: float, rng: np.random.Generator
) -> Iterator[Mutation]:
    """Endless mutations: the genes to redraw and their new values from U[-limit, limit).

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    genes : int
        Length of a genome.
    rate : float
        Share of genes redrawn, 0 to 1.
    limit : float
        Largest magnitude of a gene.
    rng : Generator
    """
    draw = KINDS[kind]
    while True:
        chosen = draw(genes, rate, rng)
        ends = np.cumsum([len(row) for row in chosen])
        values = rng.uniform(-limit, limit, ends[-1]).astype(np.float32)
        yield from zip(chosen, _split(values, ends), strict=True)


def _split(array: np.ndarray, ends: np.ndarray) -> list[np.ndarray]:
    """Cut an array into consecutive pieces (numpy.split, ten times faster)."""
    cuts = [0, *ends.tolist()]
    return [array[start:end] for start, end in itertools.pairwise(cuts)]

"""Mutations of a (1+1) lineage, drawn for many generations at once.

A mutation does not depend on any outcome, so that drawing a block of them costs little per
generation and gives the numbers that drawing them one by one would have given.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

BLOCK = 128
"""Generations drawn at once; part of what a seed means."""


@dataclasses.dataclass(frozen=True, slots=True)
class Mutations:
    """Mutations of successive generations.

    Attributes
    ----------
    redrawn : uint32 (g,)
        Number of genes that each redraws.
    genes, values : uint32 (c,), float32 (c,)
        Those genes and their new values, one mutation after the other.
    """

    redrawn: np.ndarray
    genes: np.ndarray
    values: np.ndarray


def bernoulli(genes: int, rate: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of genes of BLOCK mutations, and the genes, each with probability ``rate``."""
    places = np.flatnonzero(rng.random((BLOCK, genes), dtype=np.float32) < rate)
    ends = np.searchsorted(places, np.arange(1, BLOCK + 1) * genes)
    return np.diff(ends, prepend=0), places % genes


def exact(genes: int, rate: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """As `bernoulli`, with exactly round(rate * genes) different genes in each."""
    count = round(rate * genes)
    order = np.argsort(rng.random((BLOCK, genes), dtype=np.float32), axis=1)
    return np.full(BLOCK, count), np.sort(order[:, :count], axis=1).ravel()


KINDS: dict[str, Callable[[int, float, np.random.Generator], tuple[np.ndarray, np.ndarray]]] = {
    'bernoulli': bernoulli,
    'exact': exact,
}


def draw_mutations(
    kind: str, genes: int, rate: float, limit: float, rng: np.random.Generator
) -> Iterator[Mutations]:
    """Endless blocks of mutations: genes to redraw and new values from U[-limit, limit).

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
        redrawn, chosen = draw(genes, rate, rng)
        values = rng.uniform(-limit, limit, len(chosen)).astype(np.float32)
        yield Mutations(redrawn.astype(np.uint32), chosen.astype(np.uint32), values)

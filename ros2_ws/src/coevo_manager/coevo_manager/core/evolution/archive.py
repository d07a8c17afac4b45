"""Genomes that are kept for good, in the order in which they came."""

from __future__ import annotations

import numpy as np

from neuro_controller.core.genome import Layout, check_genomes

GENES = np.dtype(np.float32)
"""What the journal of an archive has rows of: genome after genome, gene after gene."""


class Archive:
    """A list of genomes of a layout in one array, which grows by doubling."""

    def __init__(self, layout: Layout) -> None:
        self._rows = np.empty((16, layout.genes), np.float32)
        self._size = 0

    def __len__(self) -> int:
        return self._size

    @property
    def genomes(self) -> np.ndarray:
        """The members, float32 (size, genes); a view."""
        return self._rows[: self._size]

    def add(self, genomes: np.ndarray) -> None:
        """Append genomes, float32 (k, genes)."""
        size = self._size + len(genomes)
        if size > len(self._rows):
            grown = np.empty((1 << (size - 1).bit_length(), self._rows.shape[1]), np.float32)
            grown[: self._size] = self.genomes
            self._rows = grown
        self._rows[self._size : size] = genomes
        self._size = size

    def remove(self, place: int) -> None:
        """Let a member leave; the last one takes its place."""
        self._size -= 1
        self._rows[place] = self._rows[self._size]

    @classmethod
    def of(cls, genes: np.ndarray, name: str, layout: Layout) -> Archive:
        """Return an archive of the members in a journal; ValueError, naming it, for nonsense."""
        if genes.size % layout.genes:
            raise ValueError(
                f'{name} has {genes.size} genes, expected {layout.genes} for each member'
            )
        archive = cls(layout)
        archive.add(check_genomes(genes.reshape(-1, layout.genes), name, layout))
        return archive

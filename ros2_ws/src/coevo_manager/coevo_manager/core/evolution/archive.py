"""Genomes that are kept for good, in the order in which they came."""

from __future__ import annotations

import numpy as np

from neuro_controller.core.genome import GENES, check_genomes

GENOME = np.dtype((np.float32, (GENES,)))
"""A row of an archive's journal."""


class Archive:
    """A list of genomes in one array, which grows by doubling."""

    def __init__(self) -> None:
        self._rows = np.empty((16, GENES), np.float32)
        self._size = 0

    def __len__(self) -> int:
        return self._size

    @property
    def genomes(self) -> np.ndarray:
        """The members, float32 (size, 442); a view."""
        return self._rows[: self._size]

    def add(self, genomes: np.ndarray) -> None:
        """Append genomes, float32 (k, 442)."""
        size = self._size + len(genomes)
        if size > len(self._rows):
            grown = np.empty((1 << (size - 1).bit_length(), GENES), np.float32)
            grown[: self._size] = self.genomes
            self._rows = grown
        self._rows[self._size : size] = genomes
        self._size = size

    def remove(self, place: int) -> None:
        """Let a member leave; the last one takes its place."""
        self._size -= 1
        self._rows[place] = self._rows[self._size]

    @classmethod
    def of(cls, genomes: np.ndarray, name: str) -> Archive:
        """Return an archive of the members in a journal; ValueError, naming it, for nonsense."""
        archive = cls()
        archive.add(check_genomes(genomes, name))
        return archive

"""Who plays the episodes: the interface between evolution and its evaluators."""

from __future__ import annotations

import dataclasses
import itertools
import threading
from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np

from coevo_manager.core.environment import Environment

LONGEST_BATCH = 1024
"""Most episodes worth asking for at once: some 0.1 s of one core."""


@dataclasses.dataclass(frozen=True, slots=True)
class Batch:
    """Episodes to play: pairs of one predator and one prey.

    Attributes
    ----------
    predators, prey : float32 (P, genes), (Q, genes)
        Genomes, C-contiguous. Whoever submits a batch leaves its arrays unchanged until it
        is collected or cancelled, so that an evaluator may send them again.
    predator_index, prey_index : uint32 (n,), (n,)
        Episode k is played by ``predators[predator_index[k]]`` and ``prey[prey_index[k]]``.
    noise : int
        Which starts and noise: 0 for those in which a pair always meets, else others.
    """

    predators: np.ndarray
    prey: np.ndarray
    predator_index: np.ndarray
    prey_index: np.ndarray
    noise: int = 0

    def __len__(self) -> int:
        return len(self.predator_index)


@dataclasses.dataclass(frozen=True, slots=True)
class Lineages:
    """(1+1) evolution strategies to follow: parents and the mutations of their generations.

    In each generation the parent of that time, mutated, meets all opponents, and takes the
    parent's place if it is as fit or fitter. The ticks of all episodes tell every outcome. No
    lineage knows of another.

    Attributes
    ----------
    species : str
        The lineages'; the opponents are of the other one.
    parents : float32 (k, genes)
    parent_ticks : uint64 (k,)
        Their capture ticks summed over the opponents.
    opponents : float32 (m, genes)
    redrawn : uint32 (k, g)
        Number of genes that each mutation redraws.
    genes, values : uint32 (c,), float32 (c,)
        Those genes and their new values, one mutation after the other.
    noise : int
        As of a `Batch`.
    """

    species: str
    parents: np.ndarray
    parent_ticks: np.ndarray
    opponents: np.ndarray
    redrawn: np.ndarray
    genes: np.ndarray
    values: np.ndarray
    noise: int = 0

    def __len__(self) -> int:
        return self.redrawn.size * len(self.opponents)

    def alone(self) -> list[Lineages]:
        """Return each lineage by itself."""
        ends = np.cumsum(self.redrawn.sum(axis=1, dtype=np.int64))[:-1]
        return [
            dataclasses.replace(
                self,
                parents=self.parents[k : k + 1],
                parent_ticks=self.parent_ticks[k : k + 1],
                redrawn=self.redrawn[k : k + 1],
                genes=genes,
                values=values,
            )
            for k, (genes, values) in enumerate(
                zip(np.split(self.genes, ends), np.split(self.values, ends), strict=True)
            )
        ]

    def offspring(self, ticks: np.ndarray) -> np.ndarray:
        """Return all genomes that played, as the ticks of those before each tell.

        Parameters
        ----------
        ticks : int32 (n,)
            Of all episodes, as an `Evaluator` returns them.

        Returns
        -------
        float32 (k * g, genes)
            Those of the first lineage, then those of the second, and so on.
        """
        genomes = []
        totals = ticks.reshape(*self.redrawn.shape, -1).sum(axis=2, dtype=np.int64)
        end = 0
        for k, parent in enumerate(self.parents):
            best = int(self.parent_ticks[k])
            for redrawn, total in zip(self.redrawn[k].tolist(), totals[k].tolist(), strict=True):
                start, end = end, end + redrawn
                genome = parent.copy()
                genome[self.genes[start:end]] = self.values[start:end]
                genomes.append(genome)
                if total <= best if self.species == 'predator' else total >= best:
                    parent, best = genome, total
        return np.array(genomes)


class Evaluator(Protocol):
    """Plays batches of episodes and lineages, several at a time, in any order.

    Attributes
    ----------
    environment : Environment
        Where every episode is played.
    slots : int
        Number of batches and lineages worth keeping submitted at once, so that no evaluator waits
        for work. It may change while evaluators come and go, and never changes a result.
    longest_lineage : int
        Most generations worth asking for at once, of one agent or of several: an answer should not
        take long. It never changes a result either.
    """

    environment: Environment

    @property
    def slots(self) -> int:
        """See the class."""
        ...

    @property
    def longest_lineage(self) -> int:
        """See the class."""
        ...

    def submit(self, work: Batch | Lineages) -> int:
        """Take a batch or lineages and return its ticket at once."""
        ...

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Wait for any submitted work.

        Parameters
        ----------
        timeout : float, optional
            Longest wait, s; without it, wait till something is finished.

        Returns
        -------
        (ticket, capture ticks int32 (n,)), each from 1 to the environment's episode_ticks,
        or None when the timeout passed. The ticks of lineages are those of the first one's first
        offspring against all opponents, then those of its second, and so on.
        """
        ...

    def cancel(self) -> None:
        """Forget all submitted work; none of its tickets is collected any more."""
        ...

    def close(self) -> None:
        """End whatever this evaluator started."""
        ...


def longest_lineage(environment: Environment) -> int:
    """Return how many generations of lineages take some 0.1 s, as `Evaluator` wants it."""
    return 240 if environment.physics == 'kinematic' else 1


class StoppedError(Exception):
    """Raised where an evolution was asked to stop."""


def next_answer(evaluator: Evaluator, stop: threading.Event) -> tuple[int, np.ndarray]:
    """Wait for any submitted work.

    Raises
    ------
    StoppedError
        Within 0.1 s after ``stop`` was set.
    """
    while not stop.is_set():
        answer = evaluator.collect(timeout=0.1)
        if answer is not None:
            return answer
    raise StoppedError


def all_pairs(species: str, ours: np.ndarray, theirs: np.ndarray, noise: int = 0) -> Batch:
    """Return the episodes of all of ours against all of theirs.

    Parameters
    ----------
    species : str
        Ours: 'predator' or 'prey'.
    ours, theirs : float32 (k, genes), (m, genes)
        Episode ``i * m + j`` is that of ours i and theirs j.
    noise : int
        See `Batch`.
    """
    index = np.indices((len(ours), len(theirs)), np.uint32).reshape(2, -1)
    return some_pairs(species, ours, theirs, index[0], index[1], noise)


def some_pairs(
    species: str,
    ours: np.ndarray,
    theirs: np.ndarray,
    index: np.ndarray,
    opponent: np.ndarray,
    noise: int = 0,
) -> Batch:
    """Return the episodes of ``ours[index[k]]`` against ``theirs[opponent[k]]``, for all k."""
    if species == 'predator':
        return Batch(ours, theirs, index, opponent, noise)
    return Batch(theirs, ours, opponent, index, noise)


def joined(works: Sequence[Batch | Lineages]) -> Batch | Lineages:
    """Return works of one kind with the same noise as one, whose ticks come one after the other.

    Lineages are of as many generations and against the same opponents.
    """
    if len(works) == 1:
        return works[0]
    if isinstance(works[0], Lineages):
        return _joined_lineages(cast(Sequence[Lineages], works))
    batches = cast(Sequence[Batch], works)
    predators, predator_index = _joined(
        [batch.predators for batch in batches], [batch.predator_index for batch in batches]
    )
    prey, prey_index = _joined(
        [batch.prey for batch in batches], [batch.prey_index for batch in batches]
    )
    return Batch(predators, prey, predator_index, prey_index, batches[0].noise)


def _joined_lineages(lineages: Sequence[Lineages]) -> Lineages:
    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(each, name) for each in lineages])

    return dataclasses.replace(
        lineages[0],
        parents=column('parents'),
        parent_ticks=column('parent_ticks'),
        redrawn=column('redrawn'),
        genes=column('genes'),
        values=column('values'),
    )


def _joined(
    genomes: Sequence[np.ndarray], indices: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return all genomes, once where they are the same array, and the indices into them."""
    if all(these is genomes[0] for these in genomes):
        return genomes[0], np.concatenate(indices)
    firsts = itertools.accumulate((len(these) for these in genomes), initial=0)
    moved = [index + np.uint32(first) for index, first in zip(indices, firsts, strict=False)]
    return np.concatenate(genomes), np.concatenate(moved)


def evaluate_all(
    evaluator: Evaluator,
    predators: np.ndarray,
    prey: np.ndarray,
    stop: threading.Event,
    noise: int = 0,
) -> np.ndarray:
    """Play every predator against every prey.

    Parameters
    ----------
    evaluator : Evaluator
    predators, prey : float32 (P, genes), (Q, genes)
    stop : Event
    noise : int
        See `Batch`.

    Returns
    -------
    int32 (P, Q)
        Capture ticks.

    Raises
    ------
    StoppedError
    """
    result = np.empty((len(predators), len(prey)), np.int32)
    parts = {}
    for rows in np.array_split(np.arange(len(predators)), min(evaluator.slots, len(predators))):
        batch = all_pairs('predator', predators[rows], np.ascontiguousarray(prey), noise)
        parts[evaluator.submit(batch)] = rows
    while parts:
        ticket, ticks = next_answer(evaluator, stop)
        rows = parts.pop(ticket)
        result[rows] = ticks.reshape(len(rows), len(prey))
    return result

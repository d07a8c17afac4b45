"""Who plays the episodes: the interface between evolution and its evaluators."""

from __future__ import annotations

import collections
import dataclasses
import threading
from typing import Protocol

import numpy as np

from coevo_manager.core.environment import Environment


@dataclasses.dataclass(frozen=True, slots=True)
class Batch:
    """Episodes to play: pairs of one predator and one prey.

    Attributes
    ----------
    predators, prey : float32 (P, 442), (Q, 442)
        Genomes, C-contiguous. Whoever submits a batch leaves its arrays unchanged until the batch
        is collected or cancelled, so that an evaluator may send them again.
    predator_index, prey_index : uint32 (n,), (n,)
        Episode k is played by ``predators[predator_index[k]]`` and ``prey[prey_index[k]]``.
    """

    predators: np.ndarray
    prey: np.ndarray
    predator_index: np.ndarray
    prey_index: np.ndarray

    def __len__(self) -> int:
        return len(self.predator_index)


class Evaluator(Protocol):
    """Plays batches of episodes, several at a time, in any order.

    Attributes
    ----------
    environment : Environment
        Where every episode is played.
    slots : int
        Number of batches worth keeping submitted at once, so that no evaluator waits for work (2
        for each evaluator process). It may change while evaluators come and go; it is read at the
        start of each phase and never changes a result.
    lookahead : int
        Generations worth asking for in one batch where an optimizer knows its next candidates
        should the present ones fail: some are played in vain, but there are fewer batches. Read
        as slots is.
    """

    environment: Environment

    @property
    def slots(self) -> int:
        """See the class."""
        ...

    @property
    def lookahead(self) -> int:
        """See the class."""
        ...

    def submit(self, batch: Batch) -> int:
        """Take a batch and return its ticket at once."""
        ...

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Wait for any submitted batch.

        Parameters
        ----------
        timeout : float, optional
            Longest wait, s; without it, wait till a batch is finished.

        Returns
        -------
        (ticket, capture ticks int32 (n,)), each from 1 to the environment's episode_ticks,
        or None when the timeout passed.
        """
        ...

    def cancel(self) -> None:
        """Forget every submitted batch; none of their tickets is collected any more."""
        ...

    def close(self) -> None:
        """End whatever this evaluator started."""
        ...


class StoppedError(Exception):
    """Raised where an evolution was asked to stop."""


def next_answer(evaluator: Evaluator, stop: threading.Event) -> tuple[int, np.ndarray]:
    """Wait for any submitted batch.

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


def evaluate_all(
    evaluator: Evaluator, predators: np.ndarray, prey: np.ndarray, stop: threading.Event
) -> np.ndarray:
    """Play every predator against every prey.

    Parameters
    ----------
    evaluator : Evaluator
    predators, prey : float32 (P, 442), (Q, 442)
    stop : Event

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
        index = np.indices((len(rows), len(prey)), np.uint32).reshape(2, -1)
        batch = Batch(predators[rows], np.ascontiguousarray(prey), index[0], index[1])
        parts[evaluator.submit(batch)] = rows
    while parts:
        ticket, ticks = next_answer(evaluator, stop)
        rows = parts.pop(ticket)
        result[rows] = ticks.reshape(len(rows), len(prey))
    return result


class LocalEvaluator:
    """Plays every batch in this process, when it is collected.

    Parameters
    ----------
    environment : Environment
    threads : int
        Threads of the episode kernel.
    """

    slots = 1
    lookahead = 1

    def __init__(self, environment: Environment, threads: int = 1) -> None:
        self.environment = environment
        self._threads = threads
        self._queue: collections.deque[tuple[int, Batch]] = collections.deque()
        self._tickets = 0

    def submit(self, batch: Batch) -> int:
        """Put a batch in the queue."""
        self._tickets += 1
        self._queue.append((self._tickets, batch))
        return self._tickets

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Play the oldest batch; None when there is none."""
        # Here, so that only processes that play episodes load the compiled kernel.
        from coevo_manager.core.episodes import evaluate_pairs

        if not self._queue:
            return None
        ticket, batch = self._queue.popleft()
        return ticket, evaluate_pairs(
            batch.predators,
            batch.prey,
            batch.predator_index,
            batch.prey_index,
            environment=self.environment,
            threads=self._threads,
        )

    def cancel(self) -> None:
        """Empty the queue."""
        self._queue.clear()

    def close(self) -> None:
        """Empty the queue."""
        self.cancel()

"""An evaluator that plays in the process that asks."""

from __future__ import annotations

import collections
import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.stream import EpisodeStream
from coevo_manager.core.evaluation import Batch, Lineages, longest_lineage


class LocalEvaluator:
    """Plays in this process what is submitted, while it is collected.

    Parameters
    ----------
    environment : Environment
    threads : int
        Threads to play in.
    """

    def __init__(self, environment: Environment, threads: int = 1) -> None:
        self.environment = environment
        self.slots = 4 * threads
        self.longest_lineage = longest_lineage(environment)
        self._make_streams = lambda: [EpisodeStream(environment) for _ in range(threads)]
        self._streams = self._make_streams()
        self._threads = ThreadPoolExecutor(threads)
        self._finished: collections.deque[tuple[int, np.ndarray]] = collections.deque()
        self._tickets = itertools.count(1)

    def submit(self, work: Batch | Lineages) -> int:
        """Give the work to the thread that has the least."""
        ticket = next(self._tickets)
        stream = min(self._streams, key=lambda stream: stream.pending)
        if isinstance(work, Lineages):
            stream.submit_lineages(ticket, work)
        else:
            stream.submit(
                ticket,
                work.predators,
                work.prey,
                work.predator_index,
                work.prey_index,
                work.noise,
            )
        return ticket

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Play until something is finished; None when there is nothing to play."""
        while not self._finished:
            busy = [stream for stream in self._streams if stream.pending]
            if not busy:
                return None
            spread = map if len(busy) == 1 else self._threads.map
            for results in spread(lambda stream: stream.advance(), busy):
                self._finished.extend((ticket, ticks) for ticket, ticks, _ in results)
        return self._finished.popleft()

    def cancel(self) -> None:
        """Forget all work."""
        self._streams = self._make_streams()
        self._finished.clear()

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown()

"""The work of a run, shared out in parts: what waits, what is done."""

from __future__ import annotations

import collections
import dataclasses
import itertools
from collections.abc import Iterable, Iterator

import numpy as np

from coevo_manager.core.evaluation import LONGEST_BATCH, Batch, Lineages


@dataclasses.dataclass(eq=False, slots=True)
class Part:
    """A share of a batch, or lineages: what one evaluator is asked.

    Attributes
    ----------
    ticket : int
        Ticket of the batch or lineages.
    work : Batch or Lineages
        The episodes, with the genomes that they need.
    place : slice
        Where their results lie in those of the ticket.
    refusals : int
        How many own evaluators have answered it badly.
    done : bool
        Its results are known.
    """

    ticket: int
    work: Batch | Lineages
    place: slice
    refusals: int = 0
    done: bool = False


class WorkQueue:
    """Divides batches and lineages into parts, hands them out, and puts the results together.

    A part may be handed out again when nothing was heard of it; results that come twice, or are
    not wanted any more, are ignored.
    """

    def __init__(self) -> None:
        self._tickets = itertools.count(1)
        self._waiting: collections.deque[Part] = collections.deque()
        self._results: dict[int, np.ndarray] = {}
        self._parts_left: dict[int, int] = {}
        self._finished: collections.deque[tuple[int, np.ndarray]] = collections.deque()

    @property
    def unfinished(self) -> bool:
        """Whether results of anything are awaited."""
        return bool(self._results)

    def submit(self, work: Batch | Lineages) -> int:
        """Take a batch or lineages and return its ticket."""
        ticket = next(self._tickets)
        parts = list(split(ticket, work, LONGEST_BATCH))
        self._results[ticket] = np.empty(len(work), np.int32)
        self._parts_left[ticket] = len(parts)
        self._waiting.extend(parts)
        return ticket

    def wanted(self, part: Part) -> bool:
        """Whether results of a part are awaited."""
        return not part.done and part.ticket in self._results

    def take(self) -> Part | None:
        """Return the next part that waits, None where none does."""
        while self._waiting:
            part = self._waiting.popleft()
            if self.wanted(part):
                return part
        return None

    def give_back(self, parts: Iterable[Part]) -> int:
        """Let parts wait again, before all others; return how many are wanted."""
        wanted = [part for part in parts if self.wanted(part)]
        self._waiting.extendleft(reversed(wanted))
        return len(wanted)

    def accept(self, part: Part, ticks: np.ndarray) -> None:
        """Take the results of a part, int32 (n,)."""
        if not self.wanted(part):
            return
        part.done = True
        self._results[part.ticket][part.place] = ticks
        self._parts_left[part.ticket] -= 1
        if not self._parts_left[part.ticket]:
            del self._parts_left[part.ticket]
            self._finished.append((part.ticket, self._results.pop(part.ticket)))

    def finished(self) -> tuple[int, np.ndarray] | None:
        """Return a ticket of which all is known and its results; None where there is none."""
        return self._finished.popleft() if self._finished else None

    def cancel(self) -> None:
        """Forget everything."""
        self._waiting.clear()
        self._results.clear()
        self._parts_left.clear()
        self._finished.clear()


def split(ticket: int, work: Batch | Lineages, longest: int) -> Iterator[Part]:
    """Divide a batch into parts of at most `longest` episodes, as equal as can be.

    Each has just the genomes that it needs. Lineages, or a short enough batch, are one part.
    """
    count = -(-len(work) // longest)
    if isinstance(work, Lineages) or count <= 1:
        yield Part(ticket, work, slice(0, len(work)))
        return
    bounds = np.linspace(0, len(work), count + 1).round().astype(int)
    for first, end in itertools.pairwise(bounds):
        place = slice(int(first), int(end))
        predators, predator_index = np.unique(work.predator_index[place], return_inverse=True)
        prey, prey_index = np.unique(work.prey_index[place], return_inverse=True)
        yield Part(
            ticket,
            Batch(
                work.predators[predators],
                work.prey[prey],
                predator_index.astype(np.uint32),
                prey_index.astype(np.uint32),
                work.noise,
            ),
            place,
        )

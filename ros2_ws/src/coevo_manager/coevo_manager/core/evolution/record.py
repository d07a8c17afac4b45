"""What the members of an archive achieved, period by period."""

from __future__ import annotations

import numpy as np


class Record:
    """Members in their places, and their fitness as opponents in the latest periods.

    Parameters
    ----------
    periods : int
        How many are kept; older ones are forgotten.

    Attributes
    ----------
    entered : int
        Members that entered after the first ones.
    """

    def __init__(self, periods: int) -> None:
        self.entered = 0
        self._first = 0
        self._periods = periods
        self._latest = 0
        self._size = 0
        self._members = np.empty(16, np.int64)
        self._pairs = np.zeros((16, periods), np.int64)
        self._fitness = np.zeros((16, periods), np.int64)

    def __len__(self) -> int:
        return self._size

    @property
    def members(self) -> np.ndarray:
        """The number of the member in each place, counted from 0 as they entered, int64."""
        return self._members[: self._size]

    def begin(self, count: int) -> None:
        """Let the first members enter."""
        self._first = count
        self._add(count, 0)

    def enter(self, count: int) -> None:
        """Let members enter, in the places behind all others."""
        self._add(count, self._first + self.entered)
        self.entered += count

    def _add(self, count: int, number: int) -> None:
        size = self._size + count
        if size > len(self._members):
            more = (1 << (size - 1).bit_length()) - len(self._members)
            self._members = np.pad(self._members, (0, more))
            self._pairs = np.pad(self._pairs, ((0, more), (0, 0)))
            self._fitness = np.pad(self._fitness, ((0, more), (0, 0)))
        self._members[self._size : size] = np.arange(number, number + count)
        self._pairs[self._size : size] = self._fitness[self._size : size] = 0
        self._size = size

    def use(self, period: int, places: np.ndarray, pairs: int, fitness: np.ndarray) -> np.ndarray:
        """Note the fitness that members achieved as opponents, summed over pairs, in ticks.

        Returns
        -------
        int64 (k, 4)
            The rows of `of`'s ``uses``.
        """
        self._go_on(period)
        column = period % self._periods
        self._pairs[places, column] += pairs
        self._fitness[places, column] += fitness
        members = self._members[places]
        return np.stack(np.broadcast_arrays(period, members, pairs, fitness), axis=1)

    def _go_on(self, period: int) -> None:
        """Forget the periods that are too old once a period has begun."""
        for begun in range(max(self._latest + 1, period - self._periods + 1), period + 1):
            self._pairs[:, begun % self._periods] = 0
            self._fitness[:, begun % self._periods] = 0
        self._latest = max(self._latest, period)

    def means(self) -> np.ndarray:
        """Return the members' mean fitness in each period, 0 where not used, (size, periods)."""
        used = np.maximum(self._pairs[: self._size], 1)
        return self._fitness[: self._size] / used

    def dominated(self, rng: np.random.Generator, tried: int) -> int:
        """Try used members at random; return the place of the first that is dominated, else -1.

        It is where some other member's mean is as high or higher in every period.
        """
        means = self.means()
        used = np.flatnonzero(self._pairs[: self._size].any(axis=1))
        for place in rng.permutation(used)[:tried].tolist():
            others = (means >= means[place]).all(axis=1)
            others[place] = False
            if others.any():
                return place
        return -1

    def remove(self, place: int) -> None:
        """Let a member leave; the last one takes its place."""
        self._size -= 1
        for rows in (self._members, self._pairs, self._fitness):
            rows[place] = rows[self._size]

    @classmethod
    def of(cls, periods: int, first: int, left: np.ndarray, uses: np.ndarray) -> Record:
        """Return what a history led to.

        Parameters
        ----------
        periods : int
        first : int
            Members that it began with.
        left : int64 (entered,)
            The place that became free after each entry, or -1.
        uses : int64 (u, 4)
            Period, member, pairs, fitness of each use, the oldest first.

        Raises
        ------
        ValueError
            It makes no sense.
        """
        record = cls(periods)
        record.begin(first)
        for place in left.tolist():
            record.enter(1)
            if not -1 <= place < len(record):
                raise ValueError(f'a member left place {place} of {len(record)}')
            if place >= 0:
                record.remove(place)
        period, member, pairs, fitness = uses.T
        if len(uses):
            everyone = first + record.entered
            if member.min() < 0 or member.max() >= everyone or period.min() < 0:
                raise ValueError(f'a use is of no member of {everyone}')
            record._latest = int(period[-1])
            recent = period > record._latest - periods
            where = member[recent], period[recent] % periods
            for rows, values in ((record._pairs, pairs), (record._fitness, fitness)):
                sums = np.zeros((everyone, periods), np.int64)
                np.add.at(sums, where, values[recent])
                rows[: len(record)] = sums[record.members]
        return record

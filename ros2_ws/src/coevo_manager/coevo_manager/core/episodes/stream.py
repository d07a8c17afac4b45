"""Episodes as a stream: requests come and go while the lanes stay full."""

from dataclasses import dataclass

import numpy as np

from coevo_manager.core.episodes.lanes import KinematicPlayer
from coevo_manager.core.episodes.schedule import (
    CHANGE,
    CHOSEN,
    END,
    EPISODE,
    FIRST,
    NOBODY,
    REQUEST,
    Rings,
)


class _Ring:
    """An array indexed by ever-growing numbers n, which lie in row n % length."""

    def __init__(self, dtype):
        self.array = np.zeros(1, dtype)
        self.first = 0
        self.end = 0

    def extend(self, count):
        """Make room for `count` more rows and return their indices."""
        size = len(self.array)
        if self.end - self.first + count > size:
            kept = np.arange(self.first, self.end)
            grown = 1 << (self.end - self.first + count - 1).bit_length()
            larger = np.zeros((grown, *self.array.shape[1:]), self.array.dtype)
            larger[kept % grown] = self.array[kept % size]
            self.array = larger
        self.end += count
        return self.rows(self.end - count, self.end)

    def rows(self, first, end):
        """Return the indices of the rows with these numbers."""
        return np.arange(first, end) % len(self.array)


@dataclass(eq=False)
class _Request:
    number: int
    ticket: object
    first: dict
    end_episode: int


@dataclass(eq=False)
class _Group:
    """Lineages that were asked for together: their results, None of those that go on."""

    ticket: object
    results: list


@dataclass(eq=False)
class _Place:
    """The place of a lineage in its group: the ticket of its own request."""

    group: _Group
    number: int


def _completed(ticket, ticks, complexity):
    """Return the results that are complete with those of a request."""
    if not isinstance(ticket, _Place):
        return [(ticket, ticks, complexity)]
    group = ticket.group
    group.results[ticket.number] = ticks, complexity
    if None in group.results:
        return []
    return [(group.ticket, *map(np.concatenate, zip(*group.results, strict=True)))]


def _make_player(environment, measure):
    if environment.physics == 'kinematic':
        return KinematicPlayer(environment, measure)
    from coevo_manager.core.episodes.pymunk_player import PymunkPlayer

    return PymunkPlayer(environment, measure)


class EpisodeStream:
    """Plays the episodes of many requests in the order in which they came.

    A request's episodes need not start together or end together, so the lanes never idle while any
    request waits. The result of an episode depends on its two genomes and the environment alone.
    Where the environment has each pair play several episodes, their ticks are summed and their
    complexities averaged.

    Parameters
    ----------
    environment : Environment
    measure : bool
        Whether to measure the complexity of the behaviours too (paper section 4); zeros otherwise.
    """

    def __init__(self, environment, measure=False):
        self.environment = environment
        self._player = _make_player(environment, measure)
        self._genomes = _Ring((np.float32, (environment.layout.genes,)))
        self._episodes = _Ring(EPISODE)
        self._mutations = _Ring(np.int64)
        self._changes = _Ring(CHANGE)
        self._requests = _Ring(REQUEST)
        self._queue = np.zeros(4, np.int64)
        self._queue[CHOSEN] = NOBODY
        self._waiting = []

    @property
    def pending(self):
        """Requests that are not finished."""
        return len(self._waiting)

    def submit(self, ticket, predators, prey, predator_index, prey_index, noise=0):
        """Queue a request.

        Parameters
        ----------
        ticket : object
            Comes back with the result.
        predators, prey : float32 arrays, shapes (p, genes) and (q, genes)
        predator_index, prey_index : integer arrays, shape (n,), n >= 1
            Which predator meets which prey.
        noise : int
            Which starts and noise: 0 for those in which a pair always meets, else others.
        """
        first = self._numbers()
        rows = self._genomes.extend(len(predators) + len(prey))
        self._genomes.array[rows[: len(predators)]] = predators
        self._genomes.array[rows[len(predators) :]] = prey
        self._add_episodes(
            np.asarray(predator_index) + first['genomes'],
            np.asarray(prey_index) + (first['genomes'] + len(predators)),
            noise,
        )
        self._add_request(ticket, first, ready=self._episodes.end)

    def submit_lineages(self, ticket, lineages):
        """Queue `Lineages`; the offspring of each are played one after the other.

        Parameters
        ----------
        ticket : object
            Comes back with the results, those of the first lineage's first offspring first.
        lineages : coevo_manager.core.evaluation.Lineages
        """
        group = _Group(ticket, [None] * len(lineages.parents))
        for place, lineage in enumerate(lineages.alone()):
            self._submit_lineage(_Place(group, place), lineage)

    def _submit_lineage(self, ticket, lineage):
        first = self._numbers()
        generations, opponents = lineage.redrawn.size, len(lineage.opponents)
        rows = self._genomes.extend(2 + opponents)
        self._genomes.array[rows[0]] = lineage.parents[0]
        self._genomes.array[rows[2:]] = lineage.opponents
        ours = np.full(generations * opponents, first['genomes'] + 1)
        theirs = np.tile(np.arange(opponents) + (first['genomes'] + 2), generations)
        hunting = lineage.species == 'predator'
        predators, prey = (ours, theirs) if hunting else (theirs, ours)
        self._add_episodes(predators, prey, lineage.noise)
        rows = self._changes.extend(len(lineage.genes))
        self._changes.array['gene'][rows] = lineage.genes
        self._changes.array['value'][rows] = lineage.values
        rows = self._mutations.extend(1 + generations)
        self._mutations.array[rows[0]] = first['changes']
        self._mutations.array[rows[1:]] = np.cumsum(lineage.redrawn[0]) + first['changes']
        self._add_request(
            ticket,
            first,
            ready=first['episodes'],
            size=opponents * self.environment.repetitions,
            parent=first['genomes'],
            parent_ticks=lineage.parent_ticks[0],
            sign=-1 if hunting else 1,
            mutation=first['mutations'] + 1,
        )

    def advance(self):
        """Run episodes until a request is finished, or there is room for more requests.

        Returns
        -------
        list of (ticket, int32 array of shape (n,), float32 array of shape (n, 2))
            Capture ticks and complexities of the finished requests' pairs.
        """
        return self._collect() if self._player.play(self._arrays()) else []

    def _arrays(self):
        return Rings(
            self._genomes.array,
            self._episodes.array,
            self._requests.array,
            self._mutations.array,
            self._changes.array,
            self._queue,
        )

    def _numbers(self):
        """Return the number of the next row of each ring that a request takes rows of."""
        return {
            'genomes': self._genomes.end,
            'episodes': self._episodes.end,
            'mutations': self._mutations.end,
            'changes': self._changes.end,
        }

    def _add_episodes(self, predators, prey, noise):
        repetitions = self.environment.repetitions
        rows = self._episodes.extend(len(predators) * repetitions)
        self._episodes.array['predator'][rows] = np.repeat(predators, repetitions)
        self._episodes.array['prey'][rows] = np.repeat(prey, repetitions)
        self._episodes.array['repetition'][rows] = (
            noise * repetitions + np.arange(len(rows)) % repetitions
        )
        self._episodes.array['request'][rows] = self._requests.end

    def _add_request(self, ticket, first, **fields):
        number = self._requests.end
        self._waiting.append(_Request(number, ticket, first, self._episodes.end))
        (row,) = self._requests.extend(1)
        request = self._requests.array[row]
        request['next'] = first['episodes']
        request['unfinished'] = self._episodes.end - first['episodes']
        request['size'] = request['unfinished_offspring'] = 0
        for name, value in fields.items():
            request[name] = value
        self._queue[END] = self._requests.end

    def _collect(self):
        unfinished = self._requests.array['unfinished']
        results, waiting = [], []
        for request in self._waiting:
            if unfinished[request.number % len(unfinished)]:
                waiting.append(request)
            else:
                rows = self._episodes.rows(request.first['episodes'], request.end_episode)
                episodes = self._episodes.array[rows].reshape(-1, self.environment.repetitions)
                ticks = episodes['ticks'].sum(axis=1, dtype=np.int32)
                complexity = episodes['complexity'].mean(axis=1)
                results += _completed(request.ticket, ticks, complexity)
        self._waiting = waiting
        self._requests.first = waiting[0].number if waiting else self._requests.end
        self._queue[FIRST] = self._requests.first
        first = waiting[0].first if waiting else self._numbers()
        for name, number in first.items():
            getattr(self, f'_{name}').first = number
        return results

"""Episodes as a stream: requests come and go while the lanes stay full."""

from dataclasses import dataclass

import numpy as np

from neuro_controller.core.genome import GENES, weights_of

from .lanes import KinematicPlayer
from .numbering import episode_numbers
from .pymunk_player import PymunkPlayer


class _Ring:
    """Arrays indexed by ever-growing numbers n, which lie in row n % length."""

    def __init__(self, **columns):
        self.columns = {
            name: np.zeros((1, *shape), dtype) for name, (dtype, shape) in columns.items()
        }
        self.first = 0
        self.end = 0

    def __getitem__(self, name):
        return self.columns[name]

    def extend(self, count):
        """Make room for `count` more rows and return their indices."""
        size = len(next(iter(self.columns.values())))
        if self.end - self.first + count > size:
            kept = np.arange(self.first, self.end)
            grown = 1 << (self.end - self.first + count - 1).bit_length()
            for name, column in self.columns.items():
                larger = np.zeros((grown, *column.shape[1:]), column.dtype)
                larger[kept % grown] = column[kept % size]
                self.columns[name] = larger
            size = grown
        self.end += count
        return np.arange(self.end - count, self.end) % size

    def rows(self, first, end):
        """Return the indices of the rows with these numbers."""
        return np.arange(first, end) % len(next(iter(self.columns.values())))


@dataclass(eq=False)
class _Request:
    number: int
    ticket: object
    first_genome: int
    first_episode: int
    end_episode: int


class EpisodeStream:
    """Plays the episodes of many requests in the order in which they came.

    A request's episodes need not start together or end together, so the lanes never idle while any
    request waits. The result of an episode depends on its two genomes and the environment alone.

    Parameters
    ----------
    environment : Environment
    measure : bool
        Whether to measure the complexity of the behaviours too (paper section 4); zeros otherwise.
    """

    def __init__(self, environment, measure=False):
        self.environment = environment
        player = KinematicPlayer if environment.physics == 'kinematic' else PymunkPlayer
        self._player = player(environment, measure)
        self._genomes = _Ring(weights=(np.float32, (GENES,)), number=(np.uint64, ()))
        self._episodes = _Ring(
            predator=(np.int64, ()),
            prey=(np.int64, ()),
            request=(np.int64, ()),
            ticks=(np.int32, ()),
            complexity=(np.float32, (2,)),
        )
        self._requests = _Ring(unfinished=(np.int64, ()))
        self._next = 0
        self._waiting = []

    @property
    def pending(self):
        """Requests that are not finished."""
        return len(self._waiting)

    def submit(self, ticket, predators, prey, predator_index, prey_index):
        """Queue a request.

        Parameters
        ----------
        ticket : object
            Comes back with the result.
        predators, prey : float32 arrays, shapes (p, 442) and (q, 442)
        predator_index, prey_index : integer arrays, shape (n,), n >= 1
            Which predator meets which prey.
        """
        count = len(predator_index)
        first_genome, first_episode = self._genomes.end, self._episodes.end
        rows = self._genomes.extend(len(predators) + len(prey))
        for part, genomes in ((rows[: len(predators)], predators), (rows[len(predators) :], prey)):
            self._genomes['weights'][part] = weights_of(genomes)
            if self.environment.perturbations.active:
                self._genomes['number'][part] = episode_numbers(genomes)
        rows = self._episodes.extend(count)
        self._episodes['predator'][rows] = np.asarray(predator_index) + first_genome
        self._episodes['prey'][rows] = np.asarray(prey_index) + (first_genome + len(predators))
        self._episodes['request'][rows] = self._requests.end
        request = _Request(
            self._requests.end, ticket, first_genome, first_episode, self._episodes.end
        )
        row = self._requests.extend(1)
        self._requests['unfinished'][row] = count
        self._waiting.append(request)

    def advance(self):
        """Run episodes until at least one request is finished.

        Returns
        -------
        list of (ticket, int32 array of shape (n,), float32 array of shape (n, 2))
            Capture ticks and complexities of the finished requests; empty if none was pending.
        """
        self._next, finished = self._player.play(
            self._genomes, self._episodes, self._requests['unfinished'], self._next
        )
        return self._collect() if finished else []

    def _collect(self):
        unfinished = self._requests['unfinished']
        results, waiting = [], []
        for request in self._waiting:
            if unfinished[request.number % len(unfinished)]:
                waiting.append(request)
            else:
                rows = self._episodes.rows(request.first_episode, request.end_episode)
                results.append(
                    (
                        request.ticket,
                        self._episodes['ticks'][rows],
                        self._episodes['complexity'][rows],
                    )
                )
        self._waiting = waiting
        self._requests.first = waiting[0].number if waiting else self._requests.end
        self._episodes.first = waiting[0].first_episode if waiting else self._episodes.end
        self._genomes.first = waiting[0].first_genome if waiting else self._genomes.end
        return results

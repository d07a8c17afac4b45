"""What is played next: the episodes of requests, and lineages that breed as theirs end.

Everything lies in rings: arrays, a power of two long, indexed by ever-growing numbers n in row
n modulo length. The episodes of a batch may start at any time, those of a lineage one generation
after the other. Lanes are filled by the lineage that has most generations left, since that one
would be the last to end, alone and with lanes idle; batches fill what lineages leave. Every fourth
turn goes to the oldest request, so that none waits for ever.
"""

from typing import NamedTuple

import numba
import numpy as np

from simd_lanes import HALF, compile_kernel

IDLE = -1
"""In place of an episode's number: there is none."""

FIRST, END, CHOSEN, TURN = range(4)
"""In `Rings.queue`: the requests that are not finished lie in [FIRST, END); whose turn it is, and
the count of turns."""

NOBODY = -1
"""In place of a request's number: it is nobody's turn."""

OLDEST_TURN = 4
"""Every how many turns the oldest request has its turn."""

EPISODE = np.dtype(
    [
        ('predator', np.int64),
        ('prey', np.int64),
        ('request', np.int64),
        ('repetition', np.int64),
        ('ticks', np.int32),
        ('complexity', np.float32, (2,)),
    ]
)
"""Numbers of the two genomes, of the request that asked and of the repetition among the episodes
of the pair; what came of it."""

REQUEST = np.dtype(
    [
        ('next', np.int64),
        ('ready', np.int64),
        ('unfinished', np.int64),
        ('size', np.int64),
        ('unfinished_offspring', np.int64),
        ('parent', np.int64),
        ('parent_ticks', np.int64),
        ('sign', np.int64),
        ('mutation', np.int64),
    ]
)
"""The episodes that a request asked for, and the state of a lineage.

next : number of the episode to start next
ready : one more than the last episode that may be started
unfinished : episodes that have not ended
size : episodes of a generation of a lineage, all against all opponents; 0 for a batch
unfinished_offspring : episodes of the present offspring that have not ended
parent : number of the parent's genome; that of the offspring is the next
parent_ticks : capture ticks of the parent summed over the opponents
sign : 1 where many ticks are fit (prey), else -1
mutation : number of the next mutation
"""

CHANGE = np.dtype([('gene', np.int64), ('value', np.float32)])
"""A gene that a mutation redraws, and its new value."""


class Rings(NamedTuple):
    """The arrays of a stream.

    Attributes
    ----------
    genomes : float32 array, shape (g, genes)
    episodes, requests, changes : arrays of EPISODE, REQUEST and CHANGE
    mutations : int64 array
        One more than the number of each mutation's last change.
    queue : int64 array, shape (4,)
        FIRST, END, CHOSEN and TURN.
    """

    genomes: np.ndarray
    episodes: np.ndarray
    requests: np.ndarray
    mutations: np.ndarray
    changes: np.ndarray
    queue: np.ndarray


@numba.njit
def row(ring, number):
    """Return the row of a ring that holds a number."""
    return ring[number & (len(ring) - 1)]


@compile_kernel
def next_episode(rings):
    """Return the number of the episode to start now; IDLE where there is none."""
    if rings.queue[CHOSEN] == NOBODY:
        rings.queue[CHOSEN] = _choose(rings)
        if rings.queue[CHOSEN] == NOBODY:
            return IDLE
    request = row(rings.requests, rings.queue[CHOSEN])
    if request['next'] == request['ready']:
        _breed(rings, request)
    episode = request['next']
    request['next'] = episode + 1
    if request['next'] == request['ready'] or (request['size'] == 0 and episode % HALF == 0):
        rings.queue[CHOSEN] = NOBODY
    return episode


@numba.njit
def _choose(rings):
    """Return the number of the request whose turn it is."""
    rings.queue[TURN] += 1
    oldest = rings.queue[TURN] % OLDEST_TURN == 0
    chosen, most = NOBODY, -1
    for number in range(rings.queue[FIRST], rings.queue[END]):
        request = row(rings.requests, number)
        may_breed = request['unfinished_offspring'] == 0 and request['unfinished'] > 0
        if request['next'] < request['ready'] or (request['size'] > 0 and may_breed):
            left = request['unfinished'] // request['size'] if request['size'] > 0 else 0
            if left > most:
                chosen, most = number, left
            if oldest:
                break
    return chosen


@numba.njit
def _breed(rings, request):
    """Make the next offspring of a lineage, and its episodes ready."""
    genome = row(rings.genomes, request['parent'] + 1)
    genome[:] = row(rings.genomes, request['parent'])
    mutation = request['mutation']
    for number in range(row(rings.mutations, mutation - 1), row(rings.mutations, mutation)):
        change = row(rings.changes, number)
        genome[change['gene']] = change['value']
    request['mutation'] = mutation + 1
    request['unfinished_offspring'] = request['size']
    request['ready'] += request['size']


@compile_kernel
def end_episode(rings, number, ticks, predator_complexity, prey_complexity):
    """Note how an episode ended; return whether its request is finished by that."""
    episode = row(rings.episodes, number)
    episode['ticks'] = ticks
    episode['complexity'][0] = predator_complexity
    episode['complexity'][1] = prey_complexity
    request = row(rings.requests, episode['request'])
    request['unfinished'] -= 1
    if request['size'] > 0:
        request['unfinished_offspring'] -= 1
        if request['unfinished_offspring'] == 0:
            _select(rings, request)
    return request['unfinished'] == 0


@numba.njit
def _select(rings, request):
    """Let the offspring that has met all opponents take its parent's place if it is as fit."""
    ticks = 0
    for number in range(request['next'] - request['size'], request['next']):
        ticks += row(rings.episodes, number)['ticks']
    if request['sign'] * ticks >= request['sign'] * request['parent_ticks']:
        parent = row(rings.genomes, request['parent'])
        parent[:] = row(rings.genomes, request['parent'] + 1)
        request['parent_ticks'] = ticks

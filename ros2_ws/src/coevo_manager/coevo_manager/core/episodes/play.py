"""Episodes between predators and prey: how long each prey lives."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.stream import EpisodeStream
from coevo_manager.core.episodes.trace import Trace, trace_pair
from neuro_controller.core.genome import check_genomes

__all__ = [
    'Environment',
    'EpisodeStream',
    'Trace',
    'evaluate_matrix',
    'evaluate_pairs',
    'fitness',
    'measure_pairs',
    'trace_pair',
]

_CHUNK = 128
"""Episodes a thread takes at a time, at most: few enough for all to end together, and enough for
threads not to wait for Python's lock."""


def evaluate_pairs(
    predators, prey, predator_index, prey_index, environment=Environment(), threads=1
):
    """Let pairs of genomes meet, one episode a pair.

    Parameters
    ----------
    predators, prey : array_like, float32, shapes (p, genes) and (q, genes)
        Genes in [-5, 5].
    predator_index, prey_index : array_like of int, shape (n,)
        Episode i is between ``predators[predator_index[i]]`` and ``prey[prey_index[i]]``.
    environment : Environment
    threads : int
        Threads to spread the episodes over; the result does not depend on it.

    Returns
    -------
    int32 array, shape (n,)
        Tick in which the prey was captured, from 1; the length of an episode if it was not. Where
        ``environment.repetitions`` is more than 1, the sum over the pair's episodes.

    Raises
    ------
    ValueError
        In one sentence, if a genome, an index or the number of threads is wrong.

    Examples
    --------
    >>> import numpy as np
    >>> import red_queen as rq
    >>> hunters, hunted = rq.random_genomes(6, np.random.default_rng(1)).reshape(2, 3, -1)
    >>> rq.evaluate_pairs(hunters, hunted, [0, 2], [1, 1])
    array([1000, 1000], dtype=int32)
    """
    return _run(predators, prey, predator_index, prey_index, environment, threads, measure=False)[
        0
    ]


def measure_pairs(
    predators, prey, predator_index, prey_index, environment=Environment(), threads=1
):
    """Let pairs of genomes meet and measure how complex their behaviour is (paper section 4).

    Parameters
    ----------
    predators, prey, predator_index, prey_index, environment, threads
        As for `evaluate_pairs`.

    Returns
    -------
    ticks : int32 array, shape (n,)
        As from `evaluate_pairs`.
    complexity : float32 array, shape (n, 2)
        Of predator and prey, rad/s per tick, see `coevo_manager.core.behaviour.complexity`.

    Examples
    --------
    >>> import numpy as np
    >>> import red_queen as rq
    >>> hunters, hunted = rq.random_genomes(6, np.random.default_rng(1)).reshape(2, 3, -1)
    >>> ticks, complexity = rq.measure_pairs(hunters, hunted, [0, 2], [1, 1])
    >>> complexity.shape
    (2, 2)
    """
    return _run(predators, prey, predator_index, prey_index, environment, threads, measure=True)


def evaluate_matrix(predators, prey, environment=Environment(), threads=1):
    """Let every predator meet every prey.

    Parameters
    ----------
    predators, prey, environment, threads
        As for `evaluate_pairs`.

    Returns
    -------
    int32 array, shape (p, q)
        Capture ticks, predators in rows and prey in columns.

    Examples
    --------
    >>> import red_queen as rq
    >>> run = rq.read_run('runs/mine')
    >>> last = run.snapshot(max(run.snapshots))
    >>> rq.evaluate_matrix(last.predators, last.prey, run.environment).shape
    (8, 8)
    """
    shape = (len(predators), len(prey))
    predator_index, prey_index = np.indices(shape).reshape(2, -1)
    return evaluate_pairs(
        predators, prey, predator_index, prey_index, environment, threads
    ).reshape(shape)


def fitness(ticks, species, episode_ticks=1000):
    """Return the fitness that capture ticks mean (paper A3).

    Parameters
    ----------
    ticks : array_like of int
        Capture ticks, 1 to `episode_ticks`.
    species : str
        'predator' or 'prey'.
    episode_ticks : int
        Length of an episode.

    Returns
    -------
    float64 array
        For prey t/T and for predators 1 - t/T, so that the two sum to 1.

    Examples
    --------
    >>> import red_queen as rq
    >>> rq.fitness([250, 1000], 'predator')
    array([0.75, 0.  ])
    """
    lived = np.asarray(ticks) / episode_ticks
    if species == 'prey':
        return lived
    if species == 'predator':
        return 1.0 - lived
    raise ValueError(f'species is {species!r}, expected predator or prey')


def check_index(index, count, name):
    """Return indices as int64 of shape (n,), or raise ValueError in a sentence with `name`."""
    index = np.asarray(index)
    if index.ndim != 1 or (index.size and not np.issubdtype(index.dtype, np.integer)):
        raise ValueError(
            f'{name} has shape {index.shape} and type {index.dtype}, '
            'expected whole numbers of shape (n,)'
        )
    index = index.astype(np.int64)
    if index.size and not (index.min() >= 0 and index.max() < count):
        wrong = index[(index < 0) | (index >= count)][0]
        raise ValueError(f'{name} has the value {wrong}, expected 0 to {count - 1}')
    return index


def _run(predators, prey, predator_index, prey_index, environment, threads, measure):
    predators = check_genomes(predators, 'predators', environment.layout)
    prey = check_genomes(prey, 'prey', environment.layout)
    predator_index = check_index(predator_index, len(predators), 'predator_index')
    prey_index = check_index(prey_index, len(prey), 'prey_index')
    if len(predator_index) != len(prey_index):
        raise ValueError(
            f'prey_index has {len(prey_index)} entries, '
            f'expected {len(predator_index)} as predator_index'
        )
    if threads < 1:
        raise ValueError(f'threads is {threads}, expected at least 1')

    count = len(predator_index)
    ticks, complexity = np.empty(count, np.int32), np.empty((count, 2), np.float32)
    chunk = _CHUNK if threads == 1 else min(_CHUNK, max(1, count // (4 * threads)))
    chunks = iter(range(0, count, chunk))

    def work():
        stream = EpisodeStream(environment, measure)
        for start in chunks:
            _submit_chunk(
                stream, slice(start, start + chunk), predators, prey, predator_index, prey_index
            )
            if stream.pending > 1:
                keep(stream.advance())
        while stream.pending:
            keep(stream.advance())

    def keep(results):
        for part, part_ticks, part_complexity in results:
            ticks[part], complexity[part] = part_ticks, part_complexity

    workers = min(threads, -(-count // chunk))
    if workers <= 1:
        work()
    else:
        with ThreadPoolExecutor(workers) as pool:
            for result in [pool.submit(work) for _ in range(workers)]:
                result.result()
    return ticks, complexity


def _submit_chunk(stream, part, predators, prey, predator_index, prey_index):
    """Submit some of the episodes with the genomes that they need."""
    used_predators, predator_rows = np.unique(predator_index[part], return_inverse=True)
    used_prey, prey_rows = np.unique(prey_index[part], return_inverse=True)
    stream.submit(part, predators[used_predators], prey[used_prey], predator_rows, prey_rows)

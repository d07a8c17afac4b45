"""Recorded episodes, packed small, for the report's episode player.

A packed episode is the base64 text of a raw deflate stream of channels one after the other,
little-endian, whole numbers in the units of `UNITS`:

* int16, t + 1 values each, as differences of differences: x, y and heading of the predator, then
  the prey;
* int16, t values each, as differences: left and right wheel speed of the predator, then the prey;
* uint8, t values each, as differences: of the predator, then the prey, 24 infrared activations, 25
  sensory, 10 hidden and 2 motor neurons.

Differences are from one tick to the next, the first from 0, wrapped to the width of their type.
"""

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.study import Advance, ConditionResults
from coevo_manager.core.episodes.trace import Trace
from coevo_manager.core.species import COLOURS, SPECIES
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    INFRARED_RANGE,
    INFRARED_RAYS,
    OBSTACLE_RADIUS,
    TICK,
)

UNITS = {'length': 0.001, 'turn': 4096, 'speed': 0.1, 'neuron': 31}
"""Of positions, m; headings, parts of a full turn; wheel speeds, rad/s; neurons, steps to 1."""

GENERATIONS = 4
RANKS = ('best', 'median')
EPISODES = 200
"""At most, in all conditions together, for individuals of both ranks: some 2 MB of the page."""


def ranks(conditions: Sequence[ConditionResults]) -> tuple[str, ...]:
    """Return who is shown of each generation: the best alone where there are many conditions."""
    return RANKS if sum(size(each, RANKS) for each in conditions) <= EPISODES else RANKS[:1]


def grid(
    each: ConditionResults, shown: Sequence[str], kernel: Kernel, advance: Advance
) -> dict[str, Any]:
    """Record episodes between individuals of a few generations of the first replication.

    Parameters
    ----------
    shown : sequence of str
        Who is shown of each generation, see `ranks`.

    Returns
    -------
    dict
        Ready for JSON: `generations`, `ranks`, the constants that drawing needs, and `episodes` by
        "predator generation/rank/prey generation/rank" (indices): `ticks`, `captured`, `data`.
    """
    run, snapshots = each.runs[0], each.snapshots[0]
    count = min(GENERATIONS, len(snapshots))
    chosen = [snapshots[k] for k in np.linspace(0, len(snapshots) - 1, count).round().astype(int)]
    agents = {
        species: [
            (g, rank, snapshot.population(species)[snapshot.ranking(species)[place]])
            for g, snapshot in enumerate(chosen)
            for rank, place in enumerate((0, run.configuration.population // 2)[: len(shown)])
        ]
        for species in SPECIES
    }
    predators, prey = (np.array([genome for *_, genome in agents[s]]) for s in SPECIES)
    rows, columns = np.indices((len(predators), len(prey))).reshape(2, -1)
    traces = kernel.traces(predators, prey, rows, columns, run.environment)
    episodes = {}
    for i, j, trace in zip(rows, columns, traces, strict=True):
        name = '{}/{}/{}/{}'.format(*agents['predator'][i][:2], *agents['prey'][j][:2])
        episodes[name] = {
            'ticks': trace.ticks,
            'captured': trace.captured,
            'data': pack(trace),
        }
        advance(1)
    return {
        'title': f'{each.condition.name}, {each.condition.arena}, seed {run.seed}',
        'generations': [snapshot.generation for snapshot in chosen],
        'ranks': list(shown),
        'tick': TICK,
        'units': UNITS,
        'arena': run.environment.arena.size,
        'radius': BODY_RADIUS,
        'range': INFRARED_RANGE,
        'obstacle': OBSTACLE_RADIUS if run.environment.obstacle else 0,
        'colours': [COLOURS[species] for species in SPECIES],
        'speeds': [run.environment.predator_speed, run.environment.prey_speed],
        'episodes': episodes,
    }


def size(each: ConditionResults, shown: Sequence[str]) -> int:
    """Number of episodes in a condition's grid."""
    return (min(GENERATIONS, len(each.snapshots[0])) * len(shown)) ** 2


def pack(trace: Trace) -> str:
    """Pack a trace as the module describes."""
    poses = np.array(trace.poses, float)
    poses[..., :2] /= UNITS['length']
    poses[..., 2] *= UNITS['turn'] / (2 * np.pi)
    infrared = np.clip(1 - trace.readings[..., :INFRARED_RAYS] / INFRARED_RANGE, 0, 1)
    neurons = np.concatenate([infrared, trace.inputs, trace.hidden, trace.outputs], axis=-1)
    levels = np.round(np.clip(neurons, 0, 1) * UNITS['neuron'])
    speeds = np.round(trace.wheels / UNITS['speed'])
    parts = [
        _differences(_differences(_channels(np.round(poses)).astype(np.int64).astype(np.int16))),
        _differences(_channels(speeds).astype(np.int16)),
        _differences(_channels(levels).astype(np.uint8)),
    ]
    packer = zlib.compressobj(9, wbits=-15)
    data = packer.compress(b''.join(part.tobytes() for part in parts)) + packer.flush()
    return base64.b64encode(data).decode()


def _channels(values: np.ndarray) -> np.ndarray:
    """Turn (t, 2, k) values into channels (2, k, t)."""
    return np.moveaxis(values, 0, -1)


def _differences(channels: np.ndarray) -> np.ndarray:
    """Differences along each channel, which wrap."""
    return np.diff(channels, axis=-1, prepend=channels.dtype.type(0))

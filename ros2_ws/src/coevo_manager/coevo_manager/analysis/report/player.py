"""Recorded episodes, packed small, for the report's episode player.

A packed episode is the base64 text of a raw deflate stream of channels one after the other, each
as differences from tick to tick (the first from 0), wrapped to the width of its type,
little-endian:

* int16, t + 1 values each: x, y (0.1 mm) and heading (0.1 mrad, in -pi..pi) of the predator, then
the prey;
* int16, t values each: left and right wheel speed (mrad/s) of the predator, then the prey;
* uint8, t values each, 0..255 for 0..1, of the predator, then the prey: 24 infrared activations,
25
  sensory, 10 hidden and 2 motor neurons.
"""

import base64
import zlib

import numpy as np

from coevo_manager.analysis.study import Replications
from coevo_manager.core.species import SPECIES
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    INFRARED_RANGE,
    INFRARED_RAYS,
    OBSTACLE_RADIUS,
    TICK,
)

GENERATIONS = 4
RANKS = ('best', 'median')


def grid(each: Replications, kernel, advance) -> dict:
    """Record episodes between individuals of a few generations of the first replication.

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
            for rank, place in enumerate((0, run.configuration.population // 2))
        ]
        for species in SPECIES
    }
    episodes = {}
    for g, rank, predator in agents['predator']:
        for h, other, prey in agents['prey']:
            trace = kernel.trace(predator, prey, run.environment)
            episodes[f'{g}/{rank}/{h}/{other}'] = {
                'ticks': int(trace.ticks),
                'captured': bool(trace.captured),
                'data': pack(trace),
            }
            advance(1)
    return {
        'title': f'{each.condition.name}, {each.condition.arena}, seed {run.seed}',
        'generations': [snapshot.generation for snapshot in chosen],
        'ranks': list(RANKS),
        'tick': TICK,
        'arena': run.environment.arena.size,
        'radius': BODY_RADIUS,
        'range': INFRARED_RANGE,
        'obstacle': OBSTACLE_RADIUS if run.environment.obstacle else 0,
        'speeds': [run.environment.predator_speed, run.environment.prey_speed],
        'episodes': episodes,
    }


def size(each: Replications) -> int:
    """Number of episodes in a condition's grid."""
    return (min(GENERATIONS, len(each.snapshots[0])) * len(RANKS)) ** 2


def pack(trace) -> str:
    """Pack a trace as the module describes."""
    poses = np.array(trace.poses, float)
    poses[..., 2] = (poses[..., 2] + np.pi) % (2 * np.pi) - np.pi
    infrared = np.clip(1 - np.asarray(trace.readings)[..., :INFRARED_RAYS] / INFRARED_RANGE, 0, 1)
    neurons = np.concatenate([infrared, trace.inputs, trace.hidden, trace.outputs], axis=-1)
    parts = [
        _differences(np.round(poses * 1e4).astype(np.int16)),
        _differences(np.round(np.asarray(trace.wheels) * 1e3).astype(np.int16)),
        _differences(np.round(np.clip(neurons, 0, 1) * 255).astype(np.uint8)),
    ]
    packer = zlib.compressobj(9, wbits=-15)
    return base64.b64encode(packer.compress(b''.join(parts)) + packer.flush()).decode()


def _differences(values: np.ndarray) -> bytes:
    """Channels of (t, 2, k) values one after the other, as differences that wrap."""
    channels = np.moveaxis(values, 0, -1)
    return np.diff(channels, axis=-1, prepend=channels.dtype.type(0)).tobytes()

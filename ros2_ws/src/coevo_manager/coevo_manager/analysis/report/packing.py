"""Recorded episodes, packed small, for the episode player of a page.

A packed episode is the base64 text of a raw deflate stream of channels one after the other,
little-endian, whole numbers in the units of `UNITS`:

* int16, t + 1 values each, as differences of differences: x, y and heading of the predator, then
  the prey;
* int16, t values each, as differences: left and right wheel speed of the predator, then the prey;
* uint8, t values each, as differences: of the predator, then the prey, infrared activations,
  sensory, hidden and motor neurons, as `layer_places` tells.

Differences are from one tick to the next, the first from 0, wrapped to the width of their type.
"""

import base64
import zlib
from typing import Any

import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.trace import Trace
from coevo_manager.core.species import COLOURS, SPECIES
from marxbot_sensors import CAMERA, GROUND, INFRARED, TOUCH, Sensor
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    INFRARED_RANGE,
    OBSTACLE_RADIUS,
    TICK,
)
from neuro_controller.core.genome import OUTPUTS, OWN_INPUTS, Layout

UNITS = {'length': 0.001, 'turn': 4096, 'speed': 0.1, 'neuron': 31}
"""Of positions, m; headings, parts of a full turn; wheel speeds, rad/s; neurons, steps to 1."""


def layer_places(layout: Layout) -> dict[str, Any]:
    """Return where the activations of a robot lie among its channels, ready for JSON.

    `channels` is their number, `rays` that of the infrared activations, which come first, `camera`
    the first of the camera's sectors and `sectors` their number; `bars` are rows of groups, each
    with a name, its first channel and the number of its channels.
    """
    rays = INFRARED.count
    hidden = rays + layout.inputs
    motors = hidden + layout.hidden

    def place(sensor: Sensor) -> int:
        return rays + layout.robot.inputs(sensor).start

    camera, ground, touch = place(CAMERA), place(GROUND), place(TOUCH)
    seen = [
        ('infrared groups', rays, INFRARED.neurons),
        ('camera', camera, CAMERA.count),
        ('mean', camera + CAMERA.count, 1),
    ]
    felt = [
        ('ground', ground, GROUND.count),
        ('mean', ground + GROUND.count, 1),
        ('contact', touch, 1),
        *((sensor.name, place(sensor), sensor.neurons) for sensor in layout.robot.further),
        *((name, hidden - len(OWN_INPUTS) + i, 1) for i, name in enumerate(OWN_INPUTS)),
    ]
    own = [('hidden', hidden, layout.hidden), ('translation, rotation', motors, OUTPUTS)]
    return {
        'channels': motors + OUTPUTS,
        'rays': rays,
        'camera': camera,
        'sectors': CAMERA.count,
        'bars': [seen, felt, own],
    }


def constants(environment: Environment) -> dict[str, Any]:
    """Return what drawing needs to know of an environment, ready for JSON."""
    return {
        'tick': TICK,
        'units': UNITS,
        'arena': environment.arena.size,
        'radius': BODY_RADIUS,
        'range': INFRARED_RANGE,
        'obstacle': OBSTACLE_RADIUS if environment.obstacle else 0,
        'colours': [COLOURS[species] for species in SPECIES],
        'layers': layer_places(environment.layout),
        'speeds': [environment.predator_speed, environment.prey_speed],
    }


def pack(trace: Trace) -> dict[str, Any]:
    """Return an episode ready for JSON: `ticks`, `captured` and `data`, see the module."""
    poses = np.array(trace.poses, float)
    poses[..., :2] /= UNITS['length']
    poses[..., 2] *= UNITS['turn'] / (2 * np.pi)
    infrared = np.clip(1 - trace.readings[..., : INFRARED.count] / INFRARED_RANGE, 0, 1)
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
    return {
        'ticks': trace.ticks,
        'captured': trace.captured,
        'data': base64.b64encode(data).decode(),
    }


def _channels(values: np.ndarray) -> np.ndarray:
    """Turn (t, 2, k) values into channels (2, k, t)."""
    return np.moveaxis(values, 0, -1)


def _differences(channels: np.ndarray) -> np.ndarray:
    """Differences along each channel, which wrap."""
    return np.diff(channels, axis=-1, prepend=channels.dtype.type(0))

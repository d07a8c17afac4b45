"""Named worlds: which settings of an environment make them."""

import math
from typing import Any

from marxbot_sim.core.fields import Option

_FAITHFUL = {
    'motor_map': 'signed',
    'wall_contact': 'rigid',
    'infrared_response': 'squared',
    'ground_coding': 'relative',
}
_VARIED = {**_FAITHFUL, 'start_displacement': 0.3, 'start_rotation': math.pi}

WORLDS: dict[str, dict[str, Any]] = {
    'faithful': _FAITHFUL,
    'varied': _VARIED,
    'robust': {
        **_VARIED,
        'camera_noise': 0.05,
        'infrared_noise': 0.01,
        'ground_noise': 0.005,
        'motor_noise': 0.05,
    },
}
"""What each world sets, by the names of `environment.OPTIONS`; all else keeps its default.

* ``faithful``: the authors' world, as far as it is known: signed motors, rigid walls, squared
  infrared, relative ground; perfect robots that always start at the same places.
* ``varied``: the same with starts displaced by up to 0.3 m and turned by up to pi. That is this
  project's choice; the authors state nothing of the kind.
* ``robust``: ``varied`` with noise on camera, infrared (m), ground and motors, this project's
  choice too. Predators that evolve in it lose least on imperfect robots (docs/transfer.md).
"""

WORLD = Option(
    'world',
    str,
    'faithful',
    "named world from which the settings of the environment start: the authors' (perfect robots, "
    'one start), with varied starts, or with noise too',
    choices=tuple(WORLDS),
)

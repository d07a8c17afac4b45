"""The MarxBot and its arena in numbers (SI units, REP-103 axes).

Sources: the paper's appendix A1 (Simione & Nolfi 2019) and FARSA's model of the marXbot (Massera
et al. 2014).
"""

import math
from dataclasses import dataclass

BODY_RADIUS = 0.085
"""Radius of the body, m (paper A1: diameter 17 cm)."""

WHEEL_RADIUS = 0.027
"""Radius of a wheel, m (FARSA)."""

WHEEL_SEPARATION = 0.1265
"""Distance between the wheels, m (FARSA)."""

TICK = 0.1
"""Period of sensing, control and motion, s (paper A1: 10 Hz)."""

INFRARED_RAYS = 24
"""Infrared sensors; ray i points 7.5 + 15 i degrees counter-clockwise from the heading (FARSA)."""

INFRARED_RANGE = 0.1
"""Reach of an infrared ray from the body's rim, m (FARSA)."""

CAMERA_SECTORS = 8
"""Camera sectors; sector k spans [45 k, 45 (k + 1)) degrees counter-clockwise
from the heading (paper A2)."""

GROUND_POSITIONS = ((0.0435, 0.049), (0.0435, -0.049), (-0.0435, 0.049), (-0.0435, -0.049))
"""Ground sensors in the body frame, x forward and y left, m (FARSA)."""

OBSTACLE_RADIUS = 0.05
"""Radius of the cylinder at the centre of the arena, m (paper section 5)."""

CONTACT_DEPTH = 1e-5
"""Contact is felt where a wall or the obstacle stops more of a tick's motion than this, m: the
threshold of the traction sensor (paper A2). A robot that turns on the spot beside a wall, pushing
by less than float32 can tell, is free of it."""

RIM_TURN_PER_METRE = BODY_RADIUS / (0.5 * WHEEL_SEPARATION) ** 2
"""Turn of a robot for each metre of sliding along a wall or the obstacle that friction at its rim
takes, rad/m (derived in docs/physics.md)."""

MAX_RIM_TURN = 0.5
"""Most that contact with a wall or the obstacle turns a robot in a tick, rad."""

WALL_CONTACTS = ('rigid', 'slide', 'undo')
"""What contact with a wall or the obstacle may do: let a robot slide against friction and turn it
toward facing what it presses against, as rigid bodies do; let it slide and never turn it; undo the
whole move, position and heading (FARSA's kinematic mode)."""

START_POSES = ((-0.5, 0.0, 0.0), (0.5, 0.0, math.pi))
"""Start of predator and prey: x and y in m, heading in rad (paper A3: facing each other)."""

PREDATOR_WHEEL_SPEED = {False: 8.5, True: 10.0}
"""Highest wheel speed of a predator in the open arena and with the obstacle, rad/s (paper A1)."""

PREY_WHEEL_SPEED = 10.0
"""Highest wheel speed of a prey, rad/s (paper A1)."""


@dataclass(frozen=True)
class Arena:
    """A square arena with black walls, its origin at the centre.

    Attributes
    ----------
    size : float
        Side of the square, m, at least 0.5.
    obstacle : bool
        Whether the cylinder stands at the centre.
    wall_friction : float
        Coulomb coefficient at walls and obstacle, >= 0: how many metres of sliding one metre
        of stopped approach costs.
    wall_contact : str
        What contact with walls and obstacle does, one of `WALL_CONTACTS`.

    Raises
    ------
    ValueError
        If a value is out of its range.
    """

    size: float = 3.0
    obstacle: bool = False
    wall_friction: float = 0.5
    wall_contact: str = 'rigid'

    def __post_init__(self):
        if not 0.5 <= self.size < math.inf:
            raise ValueError(
                f'arena size is {self.size}, expected a length in metres of at least 0.5'
            )
        if not 0.0 <= self.wall_friction < math.inf:
            raise ValueError(
                f'wall_friction is {self.wall_friction}, expected a number of at least 0'
            )
        if self.wall_contact not in WALL_CONTACTS:
            raise ValueError(
                f'wall_contact is {self.wall_contact!r}, '
                f'expected one of {", ".join(WALL_CONTACTS)}'
            )

"""The MarxBot and its arena in numbers (SI units, REP-103 axes).

Sources: the paper's appendix A1 (Simione & Nolfi 2019) and FARSA's model of the marXbot (Massera
et al. 2014).
"""

import math
from dataclasses import dataclass

from marxbot_sensors import CAMERA, INFRARED
from marxbot_sim.core.fields import check_fields, described

ROBOTS = ('predator', 'prey')
"""Names of the robots, in the order of every axis that stands for them."""

BODY_RADIUS = 0.085
"""Radius of the body, m (paper A1: diameter 17 cm)."""

WHEEL_RADIUS = 0.027
"""Radius of a wheel, m (FARSA)."""

WHEEL_SEPARATION = 0.1265
"""Distance between the wheels, m (FARSA)."""

TICK = 0.1
"""Period of sensing, control and motion, s (paper A1: 10 Hz)."""

SLOWEST, FASTEST = 0.001, 1000.0
"""Simulated over real time, where what is simulated or replayed keeps pace with it."""

INFRARED_RAYS = INFRARED.count
"""Infrared sensors; ray i points 7.5 + 15 i degrees counter-clockwise from the heading (FARSA)."""

INFRARED_RANGE = INFRARED.high
"""Reach of an infrared ray from the body's rim, m (FARSA)."""

CAMERA_SECTORS = CAMERA.count
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

START_DISTANCE = 1.0
"""Distance between the robots when an episode starts, m (the authors' later code; the paper does
not state it)."""

START_POSES = ((-START_DISTANCE / 2, 0.0, 0.0), (START_DISTANCE / 2, 0.0, math.pi))
"""Start of predator and prey: x and y in m, heading in rad (paper A3: facing each other)."""

PREDATOR_WHEEL_SPEED = {False: 8.5, True: 10.0}
"""Highest wheel speed of a predator in the open arena and with the obstacle, rad/s (paper A1)."""

PREY_WHEEL_SPEED = 10.0
"""Highest wheel speed of a prey, rad/s (paper A1)."""

PHYSICS = ('kinematic', 'pymunk')
"""How bodies can move: exactly, in the compiled kernel, or as rigid bodies."""


@dataclass(frozen=True)
class Arena:
    """A square arena with black walls, its origin at the centre.

    Raises
    ------
    ValueError
        A field is out of its range, in one sentence.
    """

    size: float = described(3.0, 'side of the square', 'm', minimum=0.5)
    obstacle: bool = described(False, 'whether the cylinder stands at the centre')
    wall_friction: float = described(
        0.5,
        'Coulomb coefficient at walls and obstacle: how many metres of sliding one metre of '
        'stopped approach costs',
        minimum=0.0,
        maximum=1e6,
    )
    wall_contact: str = described(
        'rigid',
        'contact with walls and obstacle lets a robot slide and turns it toward them, lets it '
        'slide without turning, or undoes its move',
        choices=WALL_CONTACTS,
    )

    def __post_init__(self):
        check_fields(self)

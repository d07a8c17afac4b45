"""Imperfect robots: what separates a simulated MarxBot from a real one, as one set of numbers."""

import math
from dataclasses import dataclass, fields

from marxbot_sim.core.fields import check_fields, described
from marxbot_sim.core.parameters import START_DISTANCE

ROBOTS = ('both', 'predator', 'prey')
"""Whom perturbations can affect."""

MAX_LATENCY_TICKS = 10
MAX_START_DISTANCE = 2.0
MAX_START_DISPLACEMENT = 0.35
"""Farthest that a start may be displaced, m: the robots still stand clear of each other and of the
obstacle, and in an arena of 3 m of its walls."""

_OF_STARTS = ('start_distance', 'start_displacement', 'start_rotation', 'robots', 'seed')


@dataclass(frozen=True)
class Perturbations:
    """How far the robots' bodies, sensors and motors are from perfect.

    The defaults are a perfect robot, and are left out of the computation: its results are the same
    bit for bit. All random values are drawn anew for each episode from `seed`, the number of the
    episode, the robot and the tick; episodes of the same number share them, whoever plays (common
    random numbers).

    An infrared distance is disturbed only within range; it may leave the range and so be lost, and
    is never negative. Camera and ground readings are kept in [0, 1]. With latency the wheels stand
    still until the first command. A low battery carries slower commands out as they are; where a
    command is lost, the wheels keep the one before.

    Raises
    ------
    ValueError
        A field is out of its range, in one sentence.

    Examples
    --------
    >>> import red_queen as rq
    >>> rq.Environment(perturbations=rq.Perturbations(camera_noise=0.05)).perturbations.active
    True
    """

    wheel_radius_scale: float = described(
        1.0, 'true radius of the wheels over the nominal one', minimum=0.5, maximum=2.0
    )
    wheel_separation_scale: float = described(
        1.0, 'true distance of the wheels over the nominal one', minimum=0.5, maximum=2.0
    )
    infrared_noise: float = described(
        0.0, 'standard deviation of the noise on an infrared distance', 'm', 0.0, 1.0
    )
    camera_noise: float = described(
        0.0,
        "standard deviation of the noise on a camera sector's fraction",
        minimum=0.0,
        maximum=1.0,
    )
    ground_noise: float = described(
        0.0,
        "standard deviation of the noise on a ground sensor's darkness",
        minimum=0.0,
        maximum=1.0,
    )
    motor_noise: float = described(
        0.0,
        "standard deviation of a wheel's way as a fraction of what it turned, which odometry does "
        'not see',
        minimum=0.0,
        maximum=1.0,
    )
    latency_ticks: int = described(
        0, 'wheel commands take effect so much late', 'ticks of 0.1 s', 0, MAX_LATENCY_TICKS
    )
    battery: float = described(
        1.0,
        'share of the highest wheel speed that the battery still gives',
        minimum=0.1,
        maximum=1.0,
    )
    command_loss: float = described(
        0.0, 'probability that a wheel command is lost', minimum=0.0, maximum=1.0
    )
    start_distance: float = described(
        START_DISTANCE,
        'distance from the start of the predator to that of the prey, which face each other, '
        'whoever is imperfect',
        'm',
        START_DISTANCE,
        MAX_START_DISTANCE,
    )
    start_displacement: float = described(
        0.0,
        'robots start in a disc of this radius about their place',
        'm',
        0.0,
        MAX_START_DISPLACEMENT,
    )
    start_rotation: float = described(
        0.0, 'robots start turned by up to this angle to either side', 'rad', 0.0, math.pi
    )
    robots: str = described('both', 'who is imperfect', choices=ROBOTS)
    seed: int = described(
        0, 'seed of the perturbations that are random', minimum=0, maximum=2**32 - 1
    )

    def __post_init__(self):
        check_fields(self)

    @property
    def active(self):
        """Whether anything that matters after the start is imperfect."""
        return any(
            getattr(self, field.name) != field.default
            for field in fields(self)
            if field.name not in _OF_STARTS
        )

    def affects(self, robot):
        """Return whether the predator, 0, or the prey, 1, is imperfect."""
        return self.robots in ('both', ROBOTS[1 + robot])

    @property
    def motor_noises(self):
        """Motor noise of predator and prey."""
        return [self.motor_noise if self.affects(robot) else 0.0 for robot in range(2)]

    @property
    def random(self):
        """Whether episodes of the same two robots differ."""
        return any(getattr(self, name) > 0 for name in _RANDOM)


_RANDOM = (
    'infrared_noise',
    'camera_noise',
    'ground_noise',
    'motor_noise',
    'command_loss',
    'start_displacement',
    'start_rotation',
)

PERFECT = Perturbations()
"""Nothing is imperfect."""

"""Imperfect robots: what separates a simulated MarxBot from a real one, as one set of numbers."""

import math
from dataclasses import dataclass, fields

ROBOTS = ('both', 'predator', 'prey')
"""Whom perturbations can affect."""

MAX_LATENCY_TICKS = 10
MAX_START_DISPLACEMENT = 0.35
"""Farthest that a start may be displaced, m: the robots still stand clear of each other and of the
obstacle."""

LIMITS = {
    'wheel_radius_scale': (0.5, 2.0),
    'wheel_separation_scale': (0.5, 2.0),
    'infrared_noise': (0.0, 1.0),
    'camera_noise': (0.0, 1.0),
    'ground_noise': (0.0, 1.0),
    'motor_noise': (0.0, 1.0),
    'latency_ticks': (0, MAX_LATENCY_TICKS),
    'battery': (0.1, 1.0),
    'command_loss': (0.0, 1.0),
    'start_displacement': (0.0, MAX_START_DISPLACEMENT),
    'start_rotation': (0.0, math.pi),
    'seed': (0, 2**32 - 1),
}
"""Least and highest value of each number; whole numbers where these are."""


@dataclass(frozen=True)
class Perturbations:
    """How far the robots' bodies, sensors and motors are from perfect.

    The defaults are a perfect robot, and are left out of the computation: its results are the same
    bit for bit. All random values are drawn anew for each episode from `seed`, the number of the
    episode, the robot and the tick; episodes of the same number share them, whoever plays (common
    random numbers).

    Attributes
    ----------
    wheel_radius_scale : float
        True radius of the wheels over the nominal one, 0.5 to 2.
    wheel_separation_scale : float
        True distance of the wheels over the nominal one, 0.5 to 2.
    infrared_noise : float
        Standard deviation of the noise on an infrared distance, m. Only what is within range is
        disturbed; it may leave the range and so be lost, and is never negative.
    camera_noise : float
        Standard deviation of the noise on a camera sector's fraction; the result is kept in [0,
        1].
    ground_noise : float
        Standard deviation of the noise on a ground sensor's darkness; the result is kept in [0,
        1].
    motor_noise : float
        Standard deviation of a wheel's speed as a fraction of what it should be (0.05: 5 %).
    latency_ticks : int
        Ticks by which a wheel command takes effect late, 0 to 10; the wheels stand still until the
        first one.
    battery : float
        Fraction of the highest wheel speed that the battery still gives, 0.1 to 1; slower commands
        are carried out as they are.
    command_loss : float
        Probability that a tick's command is lost and the wheels keep the one before, 0 to 1.
    start_displacement : float
        Robots start somewhere in a disc of this radius about their place, m, 0 to 0.35.
    start_rotation : float
        Robots start turned by up to this angle to either side, rad, 0 to pi.
    robots : str
        Who is imperfect: 'both', 'predator' or 'prey'.
    seed : int
        Seed of everything random here, 0 to 2**32 - 1.

    Raises
    ------
    ValueError
        A field is out of its range, in one sentence.
    """

    wheel_radius_scale: float = 1.0
    wheel_separation_scale: float = 1.0
    infrared_noise: float = 0.0
    camera_noise: float = 0.0
    ground_noise: float = 0.0
    motor_noise: float = 0.0
    latency_ticks: int = 0
    battery: float = 1.0
    command_loss: float = 0.0
    start_displacement: float = 0.0
    start_rotation: float = 0.0
    robots: str = 'both'
    seed: int = 0

    def __post_init__(self):
        for name, (low, high) in LIMITS.items():
            value, kind = getattr(self, name), 'a whole number' if type(low) is int else 'a number'
            number = isinstance(value, int if type(low) is int else int | float)
            if not number or isinstance(value, bool) or not low <= value <= high:
                raise ValueError(f'{name} is {value!r}, expected {kind} from {low:g} to {high:g}')
        if self.robots not in ROBOTS:
            raise ValueError(f'robots is {self.robots!r}, expected one of {", ".join(ROBOTS)}')

    @property
    def active(self):
        """Whether anything is imperfect."""
        return any(
            getattr(self, field.name) != field.default
            for field in fields(self)
            if field.name not in ('robots', 'seed')
        )


PERFECT = Perturbations()
"""Nothing is imperfect."""

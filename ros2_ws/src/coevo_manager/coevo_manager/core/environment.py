"""What an episode happens in and between whom: everything but the genomes."""

import math
from dataclasses import dataclass

from marxbot_sim.core.parameters import (
    PREDATOR_WHEEL_SPEED,
    PREY_WHEEL_SPEED,
    WALL_CONTACTS,
    Arena,
)
from marxbot_sim.core.perturbations import PERFECT, Perturbations
from marxbot_sim.core.physics import PHYSICS
from neuro_controller.core.controller import (
    GROUND_CODINGS,
    INFRARED_RESPONSES,
    MAX_WHEEL_SPEED,
    MOTOR_MAPS,
)

MAX_EPISODE_TICKS = 1_000_000

_CHOICES = {
    'motor_map': MOTOR_MAPS,
    'wall_contact': WALL_CONTACTS,
    'infrared_response': INFRARED_RESPONSES,
    'ground_coding': GROUND_CODINGS,
    'physics': PHYSICS,
}


@dataclass(frozen=True)
class Environment:
    """The conditions of an episode; the defaults are the world `faithful`, see `worlds.WORLDS`.

    Attributes
    ----------
    obstacle : bool
        Whether a cylinder stands at the centre of the arena (paper section 5).
    motor_map : str
        'signed' (2 rm - 1 in place of rm) or 'printed' (equations 3 and 4 as printed).
    predator_speed : float
        Highest wheel speed of the predator, rad/s, up to 30; None is the paper's: 8.5, or 10 with
        the obstacle.
    prey_speed : float
        Highest wheel speed of the prey, rad/s, up to 30.
    episode_ticks : int
        Length of an episode, ticks of 0.1 s, 1 to 1,000,000.
    wall_friction : float
        Coulomb coefficient at walls and obstacle, at least 0.
    wall_contact : str
        What contact with walls and obstacle does: 'rigid' (slide against friction and turn toward
        the wall), 'slide' (never turn) or 'undo' (the whole move).
    infrared_response : str
        'squared', (1 - d/range)^2, or 'linear', 1 - d/range.
    ground_coding : str
        'relative', 0.5 + 10 (g - mean) kept in 0..1, or 'raw', g.
    physics : str
        'kinematic' (exact motion, compiled) or 'pymunk' (rigid bodies, far slower).
    perturbations : Perturbations
        How far the robots are from perfect. Each robot's random numbers depend on the seed of the
        perturbations and on its opponent's genome: two genomes that are compared against the same
        opponent meet the same noise and the same start (common random numbers).

    Raises
    ------
    ValueError
        If a value is out of its range, in one sentence.
    """

    obstacle: bool = False
    motor_map: str = 'signed'
    predator_speed: float | None = None
    prey_speed: float = PREY_WHEEL_SPEED
    episode_ticks: int = 1000
    wall_friction: float = 0.5
    wall_contact: str = 'rigid'
    infrared_response: str = 'squared'
    ground_coding: str = 'relative'
    physics: str = 'kinematic'
    perturbations: Perturbations = PERFECT

    def __post_init__(self):
        if self.predator_speed is None:
            object.__setattr__(self, 'predator_speed', PREDATOR_WHEEL_SPEED[bool(self.obstacle)])
        if not isinstance(self.obstacle, bool):
            raise ValueError(f'obstacle is {self.obstacle!r}, expected True or False')
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise ValueError(
                    f'{name} is {getattr(self, name)!r}, expected one of {", ".join(choices)}'
                )
        for name in ('predator_speed', 'prey_speed'):
            _check(
                name,
                getattr(self, name),
                'rad/s above 0 and up to 30',
                lambda v: 0.0 < v <= MAX_WHEEL_SPEED,
            )
        ticks = self.episode_ticks
        if (
            isinstance(ticks, bool)
            or not isinstance(ticks, int)
            or not 1 <= ticks <= MAX_EPISODE_TICKS
        ):
            raise ValueError(
                f'episode_ticks is {ticks!r}, '
                f'expected a whole number from 1 to {MAX_EPISODE_TICKS}'
            )
        _check(
            'wall_friction',
            self.wall_friction,
            'a number of at least 0',
            lambda v: 0.0 <= v < math.inf,
        )
        if not isinstance(self.perturbations, Perturbations):
            raise ValueError(f'perturbations is {self.perturbations!r}, expected Perturbations')

    @property
    def arena(self):
        """The arena, a `marxbot_sim.core.parameters.Arena`."""
        return Arena(
            obstacle=self.obstacle,
            wall_friction=self.wall_friction,
            wall_contact=self.wall_contact,
        )

    @property
    def network_settings(self):
        """What every controller is set to, arguments of `neuro_controller`'s by name."""
        return {
            'motor_map': self.motor_map,
            'episode_ticks': self.episode_ticks,
            'infrared_response': self.infrared_response,
            'ground_coding': self.ground_coding,
        }

    @property
    def max_wheel_speeds(self):
        """Highest wheel speeds of predator and prey, rad/s."""
        return self.predator_speed, self.prey_speed


def _check(name, value, expected, holds):
    if isinstance(value, bool) or not isinstance(value, int | float) or not holds(value):
        raise ValueError(f'{name} is {value!r}, expected {expected}')

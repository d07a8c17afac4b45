"""What an episode happens in and between whom: everything but the genomes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar

from marxbot_sensors import MARXBOT, Robot
from marxbot_sim.core.fields import Option, check_fields, described, options_of, same_as
from marxbot_sim.core.parameters import PHYSICS, PREDATOR_WHEEL_SPEED, PREY_WHEEL_SPEED, Arena
from marxbot_sim.core.perturbations import PERFECT, Perturbations
from neuro_controller.core.genome import HIDDEN, MAX_HIDDEN, Layout
from neuro_controller.core.settings import (
    GROUND_CODINGS,
    INFRARED_RESPONSES,
    MAX_WHEEL_SPEED,
    MOTOR_MAPS,
)

NETWORK_SETTINGS = ('motor_map', 'episode_ticks', 'infrared_response', 'ground_coding')
"""The fields of an environment that set the controllers, all but their highest wheel speeds."""

_ARENA = options_of(Arena)


@dataclasses.dataclass(frozen=True)
class Environment:
    """The conditions of an episode; the defaults are the world `faithful`, see `worlds.WORLDS`.

    Each field says itself what it is, in which unit and within which limits. A robot's random
    numbers depend on the seed of the perturbations and on its opponent's genome: two genomes that
    are compared against the same opponent meet the same noise and the same start (common random
    numbers).

    Raises
    ------
    ValueError
        If a value is out of its range, in one sentence.

    Examples
    --------
    >>> import red_queen as rq
    >>> rq.Environment(obstacle=True).max_wheel_speeds
    (10.0, 10.0)
    """

    obstacle: bool = same_as(_ARENA['obstacle'])
    hidden: int = described(
        HIDDEN,
        "hidden neurons of the robots' controllers",
        'neurons',
        minimum=1,
        maximum=MAX_HIDDEN,
    )
    motor_map: str = described(
        'signed',
        'motor equations 3 and 4 signed (2 rm - 1 in place of rm), so that robots can drive '
        'backwards, or as printed',
        choices=MOTOR_MAPS,
    )
    predator_speed: float | None = described(
        None,
        'fastest wheel of a predator; not given: 8.5 in the open arena, 10 with the obstacle',
        'rad/s',
        above=0.0,
        maximum=MAX_WHEEL_SPEED,
    )
    prey_speed: float = described(
        PREY_WHEEL_SPEED, 'fastest wheel of a prey', 'rad/s', above=0.0, maximum=MAX_WHEEL_SPEED
    )
    episode_ticks: int = described(
        1000, 'length of an episode', 'ticks of 0.1 s', minimum=1, maximum=1_000_000
    )
    wall_friction: float = same_as(_ARENA['wall_friction'])
    wall_contact: str = same_as(_ARENA['wall_contact'])
    infrared_response: str = described(
        'squared',
        'infrared activation, (1 - d/range) squared or linear',
        choices=INFRARED_RESPONSES,
    )
    ground_coding: str = described(
        'relative',
        'ground neurons relative to their mean, 0.5 + 10 (g - mean) kept in 0..1, which tells '
        'directions, or raw darkness g',
        choices=GROUND_CODINGS,
    )
    physics: str = described(
        'kinematic',
        'exact motion, compiled; or rigid bodies, some hundred times slower',
        choices=PHYSICS,
    )
    repetitions: int = described(
        1,
        'episodes of each pair, each with starts and noise of its own; their ticks are summed',
        'episodes',
        minimum=1,
        maximum=100,
    )
    perturbations: Perturbations = PERFECT

    robot: ClassVar[Robot] = MARXBOT
    """Whose sensors both robots have; a subclass may name another."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.predator_speed is None:
            object.__setattr__(self, 'predator_speed', PREDATOR_WHEEL_SPEED[self.obstacle])
        if not isinstance(self.perturbations, Perturbations):
            raise ValueError(f'perturbations is {self.perturbations!r}, expected Perturbations')

    @property
    def arena(self) -> Arena:
        """The arena of the episode."""
        return Arena(
            obstacle=self.obstacle,
            wall_friction=self.wall_friction,
            wall_contact=self.wall_contact,
        )

    @property
    def layout(self) -> Layout:
        """What every controller is made of."""
        return Layout(self.hidden, self.robot)

    @property
    def network_settings(self) -> dict[str, Any]:
        """What every controller is set to, arguments of `neuro_controller`'s by name."""
        return {name: getattr(self, name) for name in NETWORK_SETTINGS}

    @property
    def max_wheel_speeds(self) -> tuple[float, float]:
        """Highest wheel speeds of predator and prey, rad/s."""
        assert self.predator_speed is not None
        return self.predator_speed, self.prey_speed


_PLAIN = {
    name: option
    for name, option in options_of(Environment).items()
    if name not in ('obstacle', 'repetitions')
}
_RENAMED = {'robots': 'perturbed_robots', 'seed': 'perturbation_seed'}
_PERTURBATIONS = {
    name: dataclasses.replace(option, name=_RENAMED.get(name, name))
    for name, option in options_of(Perturbations).items()
}


_PLACE = Option(
    'environment',
    str,
    'open',
    'the arena: empty, or with the central cylinder',
    choices=('open', 'obstacle'),
)

OPTIONS: dict[str, Option] = {
    option.name: option for option in (_PLACE, *_PLAIN.values(), *_PERTURBATIONS.values())
}
"""How configurations and command lines describe an environment, by name: one flat list, where
`environment` stands for the obstacle, a pair plays once, and the perturbations' `robots` and
`seed` have names that can stand alone."""

REPLACEABLE = tuple(name for name in OPTIONS if name != 'hidden')
"""What may be another than where a genome evolved; its hidden neurons are its own."""


def make_environment(values: Mapping[str, Any]) -> Environment:
    """Return the environment that values of `OPTIONS`, by name, describe; others are left out.

    Raises
    ------
    ValueError
        If a value is out of its range, in one sentence.

    Examples
    --------
    >>> import red_queen as rq
    >>> varied = rq.make_environment({**rq.WORLDS['varied'], 'environment': 'obstacle'})
    >>> varied.obstacle, varied.perturbations.start_displacement
    (True, 0.3)
    """
    checked = {
        name: option.check(values[name]) for name, option in OPTIONS.items() if name in values
    }
    perturbations = {
        name: checked[option.name]
        for name, option in _PERTURBATIONS.items()
        if option.name in checked
    }
    return Environment(
        obstacle=checked.get('environment') == 'obstacle',
        perturbations=Perturbations(**perturbations),
        **{name: checked[name] for name in _PLAIN.keys() & checked.keys()},
    )

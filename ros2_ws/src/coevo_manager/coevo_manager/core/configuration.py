"""Every number of an evolutionary run, in one place."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Iterable, Mapping
from typing import Any

from coevo_manager.core.environment import Environment
from coevo_manager.core.worlds import WORLDS
from marxbot_sim.core.parameters import WALL_CONTACTS
from marxbot_sim.core.perturbations import LIMITS, PERFECT, ROBOTS, Perturbations
from marxbot_sim.core.physics import PHYSICS
from neuro_controller.core.controller import GROUND_CODINGS, INFRARED_RESPONSES, MOTOR_MAPS


def _field(default, help, unit='', minimum=0, maximum=math.inf, choices=()):
    return dataclasses.field(
        default=default,
        metadata={
            'help': help,
            'unit': unit,
            'minimum': minimum,
            'maximum': maximum,
            'choices': choices,
        },
    )


def _perturbation(name, help, unit=''):
    low, high = LIMITS[name]
    return _field(getattr(PERFECT, name), help, unit, minimum=low, maximum=high)


@dataclasses.dataclass(frozen=True)
class Configuration:
    """What defines a run: with the same configuration two runs write the same files.

    Every field carries ``metadata``: ``help``, ``unit``, ``minimum``, ``maximum`` and ``choices``
    (empty where free), from which command lines and messages are made. The defaults are those
    of the world ``faithful``; `load_configuration` completes a preset and a world.

    Raises
    ------
    ValueError
        One sentence naming the field, its value and what was expected.
    """

    algorithm: str = _field('standard', 'how opponents, agents and survivors are chosen')
    optimizer: str = _field('one_plus_one', 'how an agent is evolved within a phase')
    seed: int = _field(1, 'seed of every random draw', minimum=0, maximum=2**32 - 1)

    population: int = _field(
        80, 'individuals of each species, N', 'individuals', minimum=2, maximum=1024
    )
    selected: int = _field(
        0,
        'agents evolved in a phase, and their opponents, n; 0: an eighth of the population '
        '(a quarter, half or all where N / 8 is not whole), all of it in the algorithm vanilla',
        'individuals',
    )
    phases: int | None = _field(
        100,
        'the run ends after this many phases; "none" where another budget ends it',
        'phases',
        minimum=1,
    )
    generations: int = _field(
        100, 'generations of one phase', 'generations', minimum=1, maximum=1_000_000
    )
    episodes: int | None = _field(
        None, 'the run never plays more episodes than this', 'episodes', minimum=1
    )
    ticks: int | None = _field(
        None, 'the run never simulates more ticks than this', 'ticks', minimum=1
    )
    swap_generations: int = _field(
        500,
        'the other species evolves after the phase that completes each such generation',
        'generations',
        minimum=1,
    )
    snapshot_generations: int = _field(
        500,
        'a snapshot after the phase that completes each such generation',
        'generations',
        minimum=1,
    )

    agent_selection: str = _field(
        'distinct',
        'the best agent against each selected opponent: each agent once (the next best where '
        'it is taken), or as often as it is the best; in the algorithm vanilla all are agents',
        choices=('distinct', 'repeated'),
    )
    ranking_weights: str = _field(
        'incumbents',
        'weighted ranking: an opponent weighs its mean fitness against the N incumbents, or '
        'against all N + n that are ranked',
        choices=('incumbents', 'all'),
    )
    replacement: str = _field(
        'ranked',
        'end of a phase: the best N of all N + n stay, or the evolved agents take the places '
        'of those they descend from',
        choices=('ranked', 'evolved'),
    )
    archive_share: float = _field(
        0.5,
        'algorithm hall_of_fame: share of the opponents drawn from the archive; the others, and '
        'those that a young archive lacks, are the fittest of the opposing population',
        minimum=0.0,
        maximum=1.0,
    )

    mutation: str = _field(
        'bernoulli',
        'optimizer one_plus_one: each gene is redrawn with the mutation rate, or exactly that '
        'share of the genes',
        choices=('bernoulli', 'exact'),
    )
    mutation_rate: float = _field(
        0.02, 'optimizer one_plus_one: share of genes redrawn', minimum=0.0, maximum=1.0
    )
    cma_candidates: int = _field(
        20, 'optimizer cma_es: candidates a generation', 'genomes', minimum=4, maximum=10_000
    )
    cma_sigma: float = _field(
        0.5, 'optimizer cma_es: first step size, in genes', minimum=1e-6, maximum=10.0
    )
    openai_pairs: int = _field(
        10,
        'optimizer openai_es: mirrored pairs of samples a generation',
        'pairs',
        minimum=1,
        maximum=10_000,
    )
    openai_sigma: float = _field(
        0.2,
        'optimizer openai_es: standard deviation of the samples, in genes',
        minimum=1e-6,
        maximum=10.0,
    )
    openai_step: float = _field(
        0.05, "optimizer openai_es: Adam's step size, in genes", minimum=0.0, maximum=10.0
    )

    world: str = _field(
        'faithful',
        "named world that the settings below start from: the authors' (perfect robots, one "
        'start), with varied starts, or with noise too',
        choices=WORLDS,
    )
    environment: str = _field(
        'open', 'the arena: empty, or with the central cylinder', choices=('open', 'obstacle')
    )
    motor_map: str = _field(
        'signed',
        'motor equations signed, so that robots can drive backwards, or as printed',
        choices=MOTOR_MAPS,
    )
    predator_speed: float | None = _field(
        None,
        'fastest wheel of a predator; not given: 8.5 in the open arena, 10 with the obstacle',
        'rad/s',
        minimum=0.0,
        maximum=30.0,
    )
    prey_speed: float = _field(10.0, 'fastest wheel of a prey', 'rad/s', minimum=0.0, maximum=30.0)
    episode_ticks: int = _field(
        1000, 'length of an episode', 'ticks of 0.1 s', minimum=1, maximum=100_000
    )
    wall_friction: float = _field(
        0.5, 'Coulomb friction of walls and obstacle', minimum=0.0, maximum=1e6
    )
    wall_contact: str = _field(
        'rigid',
        'contact with walls and obstacle lets a robot slide and turns it toward them, lets it '
        'slide without turning, or undoes its move',
        choices=WALL_CONTACTS,
    )
    infrared_response: str = _field(
        'squared',
        'infrared activation, (1 - d/range) squared or linear',
        choices=INFRARED_RESPONSES,
    )
    ground_coding: str = _field(
        'relative',
        'ground neurons relative to their mean, which tells directions, or raw darkness',
        choices=GROUND_CODINGS,
    )
    physics: str = _field(
        'kinematic',
        'exact motion, compiled; or rigid bodies, some hundred times slower',
        choices=PHYSICS,
    )

    infrared_noise: float = _perturbation(
        'infrared_noise', 'standard deviation of the noise on an infrared distance', 'm'
    )
    camera_noise: float = _perturbation(
        'camera_noise', "standard deviation of the noise on a camera sector's fraction"
    )
    ground_noise: float = _perturbation(
        'ground_noise', "standard deviation of the noise on a ground sensor's darkness"
    )
    motor_noise: float = _perturbation(
        'motor_noise', "standard deviation of a wheel's speed as a fraction of it"
    )
    latency_ticks: int = _perturbation(
        'latency_ticks', 'wheel commands take effect so much late', 'ticks of 0.1 s'
    )
    command_loss: float = _perturbation('command_loss', 'probability that a wheel command is lost')
    battery: float = _perturbation(
        'battery', 'share of the highest wheel speed that the battery still gives'
    )
    wheel_radius_scale: float = _perturbation(
        'wheel_radius_scale', 'true radius of the wheels over the nominal one'
    )
    wheel_separation_scale: float = _perturbation(
        'wheel_separation_scale', 'true distance of the wheels over the nominal one'
    )
    start_displacement: float = _perturbation(
        'start_displacement', 'robots start in a disc of this radius about their place', 'm'
    )
    start_rotation: float = _perturbation(
        'start_rotation', 'robots start turned by up to this angle to either side', 'rad'
    )
    perturbed_robots: str = _field(
        PERFECT.robots, 'whom the eleven settings before this one affect', choices=ROBOTS
    )
    perturbation_seed: int = _perturbation('seed', 'seed of those that are random')

    def __post_init__(self) -> None:
        from coevo_manager.core.evolution import algorithms, budget, optimizers

        for name, value in self.as_dict().items():
            object.__setattr__(self, name, _check_field(FIELDS[name], value))
        _check_choice('algorithm', self.algorithm, algorithms.names())
        _check_choice('optimizer', self.optimizer, optimizers.names())
        algorithm = algorithms.load(self.algorithm)
        if not self.selected:
            object.__setattr__(self, 'selected', algorithm.default_selected(self.population))
        if self.selected > self.population:
            raise ValueError(
                f'selected must not exceed population ({self.population}), got {self.selected}'
            )
        if self.replacement == 'evolved' and self.agent_selection != 'distinct':
            raise ValueError(
                'agent_selection must be distinct where replacement is evolved, '
                f'got {self.agent_selection}'
            )
        algorithm.check(self)
        budget.check(self)
        self.make_environment()

    def make_environment(self) -> Environment:
        """Return the environment of every episode of the run."""
        return Environment(
            obstacle=self.environment == 'obstacle',
            motor_map=self.motor_map,
            predator_speed=self.predator_speed,
            prey_speed=self.prey_speed,
            episode_ticks=self.episode_ticks,
            wall_friction=self.wall_friction,
            wall_contact=self.wall_contact,
            infrared_response=self.infrared_response,
            ground_coding=self.ground_coding,
            physics=self.physics,
            perturbations=self._make_perturbations(),
        )

    def _make_perturbations(self) -> Perturbations:
        values = {name: getattr(self, name) for name in LIMITS if name != 'seed'}
        return Perturbations(**values, robots=self.perturbed_robots, seed=self.perturbation_seed)

    def as_dict(self) -> dict[str, Any]:
        """Return every field by name, in the order above."""
        return {name: getattr(self, name) for name in FIELDS}


FIELDS = {field.name: field for field in dataclasses.fields(Configuration)}
_TYPES = typing.get_type_hints(Configuration)

PRESETS: dict[str, dict[str, Any]] = {
    'quick': {'world': 'varied'},
    'paper': {'world': 'faithful', 'phases': 1500},
}
"""What each preset changes in the defaults: ``quick`` shows learning in about a minute on two
cores, ``paper`` is one replication of Simione and Nolfi (2019), section 3."""


def load_configuration(values: Mapping[str, Any], preset: str = 'quick') -> Configuration:
    """Complete a preset and its world by the fields given, which may name another world.

    Parameters
    ----------
    values : mapping
        Fields of `Configuration` by name.
    preset : str
        One of `PRESETS`.

    Raises
    ------
    ValueError
        An unknown preset or key, or a value out of its range: one sentence.
    """
    _check_choice('preset', preset, PRESETS)
    unknown = [str(key) for key in values if key not in FIELDS]
    if unknown:
        raise ValueError(
            f'unknown configuration {"key" if len(unknown) == 1 else "keys"} '
            f'{", ".join(unknown)}; known are {", ".join(FIELDS)}'
        )
    world = values.get('world', PRESETS[preset]['world'])
    _check_choice('world', world, WORLDS)
    return Configuration(**{**PRESETS[preset], **WORLDS[world], **values})


def differences(ours: Configuration, theirs: Configuration) -> list[str]:
    """List the fields in which two configurations differ, as 'name: ours, theirs'."""
    return [
        f'{name}: {getattr(ours, name)}, {getattr(theirs, name)}'
        for name in FIELDS
        if getattr(ours, name) != getattr(theirs, name)
    ]


def _check_choice(name: str, value: Any, choices: Iterable[str]) -> None:
    if value not in (known := list(choices)):
        raise ValueError(f'{name} must be one of {", ".join(known)}, got {value!r}')


def _check_field(field: dataclasses.Field, value: Any) -> Any:
    """Return the value in the field's type, or raise ValueError."""
    kind = _TYPES[field.name]
    if isinstance(kind, types.UnionType):
        if value is None:
            return None
        kind = typing.get_args(kind)[0]
    limits = field.metadata
    if kind is str:
        if limits['choices']:
            _check_choice(field.name, value, limits['choices'])
        return value
    low, high = limits['minimum'], limits['maximum']
    number = isinstance(value, int if kind is int else (int, float))
    if number and not isinstance(value, bool) and low <= value <= high:
        return kind(value)
    expected = 'a whole number' if kind is int else 'a number'
    bounds = f'from {low:.10g} to {high:.10g}' if high < math.inf else f'of at least {low:.10g}'
    unit = f' ({limits["unit"]})' if limits['unit'] else ''
    raise ValueError(f'{field.name} must be {expected} {bounds}{unit}, got {value!r}')

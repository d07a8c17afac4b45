"""Every number of an evolutionary run, in one place."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from coevo_manager.core.environment import OPTIONS, Environment, make_environment
from coevo_manager.core.worlds import WORLD
from marxbot_sim.core.fields import Option, check_fields, described, options_of, same_as
from neuro_controller.core.genome import Layout

MAX_GENERATIONS = 2**32 - 1
"""Generations of a run, which messages count in 32 bits."""


@dataclasses.dataclass(frozen=True)
class Configuration:
    """What defines a run: with the same configuration two runs write the same files.

    Each field is checked by itself; whether they go together is found by
    `coevo_manager.core.evolution.load_configuration`. The defaults are the world
    ``faithful``. What the algorithm and the optimizer declare themselves is in ``parameters``, and
    is read as if it were a field.

    Raises
    ------
    ValueError
        One sentence naming the field, its value and what was expected.
    """

    algorithm: str = described('standard', 'how opponents, agents and survivors are chosen')
    optimizer: str = described('one_plus_one', 'how an agent is evolved within a phase')
    seed: int = described(1, 'seed of every random draw', minimum=0, maximum=2**32 - 1)

    population: int = described(
        80, 'individuals of each species, N', 'individuals', minimum=2, maximum=1024
    )
    selected: int = described(
        0,
        'agents evolved in a phase, and their opponents, n; 0: an eighth of the population '
        '(a quarter, half or all where N / 8 is not whole), all of it in the algorithm vanilla',
        'individuals',
        minimum=0,
    )
    episodes_per_opponent: int = described(
        1,
        'episodes in which each agent meets each opponent, each with starts and noise of its own',
        'episodes',
        minimum=1,
        maximum=100,
    )
    phases: int | None = described(
        100,
        'the run ends after this many phases; "none" where another budget ends it',
        'phases',
        minimum=1,
        maximum=MAX_GENERATIONS,
    )
    generations: int = described(
        100, 'generations of one phase', 'generations', minimum=1, maximum=1_000_000
    )
    episodes: int | None = described(
        None,
        'the run never plays more episodes than this',
        'episodes',
        minimum=1,
        maximum=2**63 - 1,
    )
    ticks: int | None = described(
        None,
        'the run never simulates more ticks than this',
        'ticks',
        minimum=1,
        maximum=2**63 - 1,
    )
    swap_generations: int = described(
        500,
        'the other species evolves after the phase that completes each such generation',
        'generations',
        minimum=1,
        maximum=MAX_GENERATIONS,
    )
    snapshot_generations: int = described(
        500,
        'a snapshot after the phase that completes each such generation',
        'generations',
        minimum=1,
        maximum=MAX_GENERATIONS,
    )

    agent_selection: str = described(
        'distinct',
        'the best agent against each selected opponent: each agent once (the next best where '
        'it is taken), or as often as it is the best; in the algorithm vanilla all are agents',
        choices=('distinct', 'repeated'),
    )
    ranking_weights: str = described(
        'incumbents',
        'weighted ranking: an opponent weighs its mean fitness against the N incumbents, or '
        'against all N + n that are ranked',
        choices=('incumbents', 'all'),
    )
    replacement: str = described(
        'ranked',
        'end of a phase: the best N of all N + n stay, or the evolved agents take the places '
        'of those they descend from',
        choices=('ranked', 'evolved'),
    )
    fresh_noise: str = described(
        'never',
        'where starts or noise are random, evolving agents meet new ones in each phase or '
        'generation; never: a pair always meets the same, as it does in rankings',
        choices=('never', 'phase', 'generation'),
    )
    reevaluate_parents: bool = described(
        False,
        'each generation evaluates the agent again, beside its candidates, so that none owes its '
        'place to luck',
    )
    optimizer_memory: str = described(
        'dropped',
        'what an optimizer learned of an individual (the moments of openai_es) is dropped at a '
        "phase's end, or kept for the next phase in which it evolves",
        choices=('dropped', 'kept'),
    )

    world: str = same_as(WORLD)
    environment: str = same_as(OPTIONS['environment'])
    hidden: int = same_as(OPTIONS['hidden'])
    motor_map: str = same_as(OPTIONS['motor_map'])
    predator_speed: float | None = same_as(OPTIONS['predator_speed'])
    prey_speed: float = same_as(OPTIONS['prey_speed'])
    episode_ticks: int = same_as(OPTIONS['episode_ticks'])
    wall_friction: float = same_as(OPTIONS['wall_friction'])
    wall_contact: str = same_as(OPTIONS['wall_contact'])
    infrared_response: str = same_as(OPTIONS['infrared_response'])
    ground_coding: str = same_as(OPTIONS['ground_coding'])
    physics: str = same_as(OPTIONS['physics'])

    infrared_noise: float = same_as(OPTIONS['infrared_noise'])
    camera_noise: float = same_as(OPTIONS['camera_noise'])
    ground_noise: float = same_as(OPTIONS['ground_noise'])
    motor_noise: float = same_as(OPTIONS['motor_noise'])
    latency_ticks: int = same_as(OPTIONS['latency_ticks'])
    command_loss: float = same_as(OPTIONS['command_loss'])
    battery: float = same_as(OPTIONS['battery'])
    wheel_radius_scale: float = same_as(OPTIONS['wheel_radius_scale'])
    wheel_separation_scale: float = same_as(OPTIONS['wheel_separation_scale'])
    start_distance: float = same_as(OPTIONS['start_distance'])
    start_displacement: float = same_as(OPTIONS['start_displacement'])
    start_rotation: float = same_as(OPTIONS['start_rotation'])
    perturbed_robots: str = same_as(OPTIONS['perturbed_robots'])
    perturbation_seed: int = same_as(OPTIONS['perturbation_seed'])

    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        check_fields(self)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__['parameters'][name]
        except KeyError:
            raise AttributeError(f'a configuration has no {name!r}', name=name, obj=self) from None

    def make_environment(self) -> Environment:
        """Return the environment of every episode of the run."""
        environment = make_environment(self.as_dict())
        return dataclasses.replace(environment, repetitions=self.episodes_per_opponent)

    @property
    def layout(self) -> Layout:
        """What the genomes of the run are genomes of."""
        return Layout(self.hidden)

    @property
    def pair_ticks(self) -> int:
        """Most ticks that the episodes of one pair last together."""
        return self.episode_ticks * self.episodes_per_opponent

    def as_dict(self) -> dict[str, Any]:
        """Return every field by name, in the order above."""
        return {**{name: getattr(self, name) for name in FIELDS}, **self.parameters}


FIELDS: dict[str, Option] = options_of(Configuration)
"""Every field that all runs have by name, with its type, default, limits, unit and help."""

PRESETS: dict[str, dict[str, Any]] = {
    'quick': {'world': 'varied'},
    'paper': {'world': 'faithful', 'phases': 1500},
}
"""What each preset changes in the defaults: ``quick`` shows learning in about a minute on two
cores, ``paper`` is one replication of Simione and Nolfi (2019), section 3."""


def differences(ours: Configuration, theirs: Configuration) -> list[str]:
    """List the fields in which two configurations differ, as 'name: ours, theirs'."""
    first, second = ours.as_dict(), theirs.as_dict()
    return [
        f'{name}: {first.get(name, "none")}, {second.get(name, "none")}'
        for name in {**first, **second}
        if name not in first or name not in second or first[name] != second[name]
    ]

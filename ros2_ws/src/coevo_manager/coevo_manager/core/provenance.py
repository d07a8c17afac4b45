"""What champions evolved in, and what a user puts in its place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from coevo_manager.core.environment import OPTIONS, Environment, make_environment
from coevo_manager.core.species import SPECIES
from coevo_manager.core.worlds import WORLDS
from neuro_controller.core.champions import Champion

EPISODE = 'episode.json'
"""The attachment that tells what an episode was played in and by whom."""


def world_settings(world: str) -> dict[str, Any]:
    """Return what a world sets, and the defaults of what only others set."""
    names = {name for settings in WORLDS.values() for name in settings}
    return {name: OPTIONS[name].default for name in names} | WORLDS[world]


def evolved_in(champion: Champion) -> dict[str, Any]:
    """Return the environment that a champion evolved in, by the names of `OPTIONS`."""
    origin = champion.origin
    values = {
        name: origin.configuration.get(name, option.default) for name, option in OPTIONS.items()
    }
    for species in ('predator', 'prey'):
        values[f'{species}_speed'] = origin.settings(species)['max_wheel_speed']
    return values


def choose_environment(
    champions: Sequence[Champion], given: Mapping[str, Any]
) -> tuple[Environment, list[str]]:
    """Return the environment in which champions shall play: their own, unless told otherwise.

    Parameters
    ----------
    champions : sequence of Champion
        One of each species, or one alone. Each brings its highest wheel speed; in all else two
        must agree.
    given : mapping
        What the user asks for in place of that, by the names of `OPTIONS`; `world` may be among
        it.

    Returns
    -------
    environment : Environment
    replaced : list of str
        A sentence for each field that is another than a champion's own.

    Raises
    ------
    ValueError
        The champions evolved in environments that differ in what was not given, or a value is out
        of its range: one sentence.
    """
    wanted = {name: given[name] for name in OPTIONS if name in given}
    if 'world' in given:
        wanted = world_settings(given['world']) | wanted
    own = {champion.species: evolved_in(champion) for champion in champions}
    if len(own) > 1:
        del own['predator']['prey_speed'], own['prey']['predator_speed']
    values, replaced = {}, []
    for name in OPTIONS:
        found = {species: world[name] for species, world in own.items() if name in world}
        if name == 'hidden' and len(set(found.values())) > 1:
            raise ValueError(
                f'predator has {found["predator"]} hidden neurons and prey {found["prey"]}, '
                'expected as many in both'
            )
        values[name] = wanted.get(name, next(iter(found.values())))
        differing = {species: v for species, v in found.items() if v != values[name]}
        if differing and name not in wanted:
            raise ValueError(
                f'{name} is {found["predator"]} where the predator evolved and {found["prey"]} '
                f'where the prey did, expected --{name.replace("_", "-")} to choose'
            )
        replaced += [
            f'{name} is {values[name]}, in place of {value} where the {species} evolved'
            for species, value in differing.items()
        ]
    return make_environment(values), replaced


def describe(champion: Champion) -> str:
    """Return what a champion is and where it evolved, in a line."""
    configuration = champion.origin.configuration
    differing = [
        f'{name} {configuration[name]}'
        for name, value in sorted(world_settings(configuration['world']).items())
        if configuration.get(name, value) != value
    ]
    world = configuration['world'] + (f' but {", ".join(differing)}' if differing else '')
    return ' '.join(f'{champion}, world {world}'.split())


def episode_record(
    environment: Environment, players: Sequence[Champion | np.ndarray]
) -> dict[str, Any]:
    """Return what an episode was played in and by whom, for JSON.

    Parameters
    ----------
    environment : Environment
    players : sequence of Champion or float arrays, shape (442,)
        Predator and prey; of mere genes nobody knows where they evolved.
    """
    record: dict[str, Any] = {'environment': asdict(environment)}
    for species, player in zip(SPECIES, players, strict=True):
        if isinstance(player, Champion):
            record[species] = {
                'description': describe(player),
                **asdict(player.origin),
                'rank': player.rank,
                'genome': player.genome.tolist(),
            }
        else:
            record[species] = {
                'description': f'{species} of unknown origin',
                'genome': player.tolist(),
            }
    return record

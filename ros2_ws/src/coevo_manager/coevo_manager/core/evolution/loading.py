"""Configurations whose fields go together, from the values that a user gives."""

from __future__ import annotations

import dataclasses
import re
import reprlib
from collections.abc import Mapping
from typing import Any

from coevo_manager.core.configuration import FIELDS, PRESETS, Configuration
from coevo_manager.core.evolution import algorithms, budget, optimizers
from coevo_manager.core.evolution.fields import all_fields, own_fields
from coevo_manager.core.worlds import WORLD, WORLDS
from marxbot_sim.core.fields import check_choice


def load_configuration(values: Mapping[str, Any], preset: str = 'quick') -> Configuration:
    """Complete a preset, its world and its algorithm's defaults by the fields given.

    Parameters
    ----------
    values : mapping
        Fields of `Configuration` and of plug-ins by name; those of plug-ins that the run does not
        use are checked and left out.
    preset : str
        One of `PRESETS`.

    Raises
    ------
    ValueError
        An unknown preset or key, a value out of its range, or values that do not go together: one
        sentence.
    """
    check_choice('preset', preset, PRESETS)
    fields = all_fields()
    unknown = [key for key in values if key not in fields]
    if unknown:
        keys, are = ('key', 'is') if len(unknown) == 1 else ('keys', 'are')
        raise ValueError(
            f'configuration {keys} {", ".join(map(_name, unknown[:5]))} {are} unknown, '
            f'expected some of {", ".join(fields)}'
        )
    world = WORLD.check(values.get('world', PRESETS[preset]['world']))
    chosen = {**PRESETS[preset], **WORLDS[world], **values}
    algorithm = algorithms.load(chosen.get('algorithm', FIELDS['algorithm'].default))
    chosen = {**algorithm.defaults, **chosen}
    parameters = {n: fields[n].check(chosen[n]) for n in chosen if n not in FIELDS}
    own = {name: value for name, value in chosen.items() if name in FIELDS}
    return complete(Configuration(**own, parameters=parameters))


def complete(configuration: Configuration) -> Configuration:
    """Return the configuration with what was left open, after checking it as a whole.

    Where n is 0 the algorithm chooses it; of ``parameters`` those are kept and completed that the
    algorithm and the optimizer declare.

    Raises
    ------
    ValueError
        Fields that do not go together, in one sentence.
    """
    algorithm = algorithms.load(configuration.algorithm)
    population = configuration.population
    given, own = (
        configuration.parameters,
        own_fields(configuration.algorithm, configuration.optimizer),
    )
    parameters = {name: given.get(name, option.default) for name, option in own.items()}
    configuration = dataclasses.replace(configuration, parameters=parameters)
    if not configuration.selected:
        configuration = dataclasses.replace(
            configuration, selected=algorithm.default_selected(population)
        )
    if configuration.selected > population:
        raise ValueError(
            f'selected is {configuration.selected}, expected at most the population, {population}'
        )
    if configuration.replacement == 'evolved' and configuration.agent_selection != 'distinct':
        raise ValueError(
            f'agent_selection is {configuration.agent_selection!r}, expected distinct where '
            'replacement is evolved'
        )
    algorithm.check(configuration)
    budget.check(configuration)
    return configuration


def memory_size(configuration: Configuration) -> int:
    """Return how many numbers the optimizer's memory of an individual has."""
    if configuration.optimizer_memory == 'dropped':
        return 0
    return optimizers.load(configuration.optimizer).memory_size(configuration.layout.genes)


def remarks(configuration: Configuration, phases: int | None) -> list[str]:
    """Return sentences about what a configuration implies and a user might not expect.

    Parameters
    ----------
    configuration : Configuration
    phases : int, optional
        Phases that the run has, where that is known.
    """
    found = []
    if configuration.algorithm == 'vanilla':
        found.append(
            f'in the algorithm vanilla everyone evolves against everyone: N = n = '
            f'{configuration.population}'
        )
    each = configuration.episodes_per_opponent
    if each > 1 and not configuration.make_environment().perturbations.random:
        found.append(
            f'the {each} episodes of each pair are equal, since neither starts nor noise differ '
            f'in the world {configuration.world} as it is set'
        )
    swap = configuration.swap_generations
    if phases is not None and phases <= -(-swap // configuration.generations):
        found.append(
            f'the prey never evolves: {phases * configuration.generations} generations end before '
            f'a phase after generation {swap}, when the species swap (swap_generations)'
        )
    return found


def _name(key: Any) -> str:
    """Return a key as it was written, or what can be shown of it."""
    plain = isinstance(key, str) and re.fullmatch(r'[\w.-]{1,60}', key)
    return key if plain else reprlib.repr(key)

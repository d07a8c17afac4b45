"""What replications share and what is set against what: conditions, and arenas that hold them."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.environment import OPTIONS
from coevo_manager.core.worlds import WORLDS

Member = TypeVar('Member', bound=Hashable)

OWN = ('seed', 'phases', 'episodes', 'ticks')
"""Fields in which replications of one condition differ: their seed, and when they end."""

PAPER = ('standard', 'simplified', 'vanilla')


@dataclass(frozen=True)
class Condition:
    """What replications have in common.

    Attributes
    ----------
    name : str
        For people, unique within its arena: the name that a campaign gave it, or its algorithm and
        the fields in which it differs from the others.
    arena : str
        The world of its episodes, for people. Conditions are set against each other within one.
    """

    name: str
    arena: str

    @property
    def slug(self) -> str:
        """Name of both in file names."""
        return f'{slug(self.arena)}_{slug(self.name)}'


def slug(text: str) -> str:
    """Return a name as it stands in file names: lower case, digits and underscores."""
    return re.sub(r'[^a-z0-9]+', '_', text.lower()).strip('_')


def assign(
    configurations: Mapping[Member, Configuration], names: Mapping[Member, str]
) -> dict[Member, Condition]:
    """Tell the condition of each run.

    Parameters
    ----------
    configurations, names : mapping
        Of each run: its configuration, and what a campaign called its condition, '' where none
        did.
    """
    arenas = _label(
        {run: (_values(c, tuple(OPTIONS)), '') for run, c in configurations.items()},
        lambda run: (
            'open arena' if configurations[run].environment == 'open' else 'arena with obstacle'
        ),
        lambda run: configurations[run].world,
        lambda run, differing: _setting(configurations[run], differing),
    )
    conditions: dict[Member, Condition] = {}
    for arena in dict.fromkeys(arenas.values()):
        members = [run for run in configurations if arenas[run] == arena]
        fields = dict.fromkeys(name for run in members for name in configurations[run].as_dict())
        rest = [name for name in fields if name not in (*OWN, 'world', *OPTIONS)]
        labels = _label(
            {run: (_values(configurations[run], rest), names[run]) for run in members},
            lambda run: _readable(names[run]) or _algorithm(configurations[run]),
            lambda run: '',
            lambda run, differing: _phrases(configurations[run], differing),
        )
        conditions |= {run: Condition(labels[run], arena) for run in members}
    return conditions


def order(condition: Condition, configuration: Configuration) -> tuple[Any, ...]:
    """Return a key to sort by: the open arena first, and the paper's algorithms."""
    algorithm = configuration.algorithm
    place = PAPER.index(algorithm) if algorithm in PAPER else len(PAPER)
    obstacle = configuration.environment != 'open'
    return obstacle, condition.arena, place, algorithm, condition.name


def without_obstacle(configuration: Configuration) -> Configuration:
    """Return the same condition in the open arena (section 5), seed and end of the run aside."""
    own: dict[str, Any] = {'seed': 0, 'phases': 1, 'episodes': None, 'ticks': None}
    return replace(configuration, environment='open', predator_speed=None, **own)


def _label(
    groups: Mapping[Member, tuple[dict[str, Any], str]],
    base: Callable[[Member], str],
    given: Callable[[Member], str],
    describe: Callable[[Member, Sequence[str]], list[str]],
) -> dict[Member, str]:
    """Name groups of equal content: by a base, and where several share it, by what differs.

    Parameters
    ----------
    groups : mapping
        Of each member: the fields that tell groups apart, and a name that does too.
    given : callable
        A name that is used where it tells all groups apart.
    describe : callable
        What is said where it does not, given the fields in which the groups differ.
    """
    labels: dict[Member, str] = {}
    for name in dict.fromkeys(base(member) for member in groups):
        members = [member for member in groups if base(member) == name]
        distinct: list[tuple[dict[str, Any], str]] = []
        for member in members:
            if groups[member] not in distinct:
                distinct.append(groups[member])
        if len(distinct) == 1:
            labels |= dict.fromkeys(members, name)
            continue
        if _tells_apart(given, groups, members):
            labels |= {member: f'{name}, {given(member)}' for member in members}
            continue
        first = distinct[0][0]
        differing = [f for f in first if any(group[f] != first[f] for group, _ in distinct)]
        for group in distinct:
            same = [member for member in members if groups[member] == group]
            labels |= dict.fromkeys(same, ', '.join([name, *describe(same[0], differing)]))
    return labels


def _tells_apart(
    given: Callable[[Member], str],
    groups: Mapping[Member, tuple[dict[str, Any], str]],
    members: Sequence[Member],
) -> bool:
    """Return whether each group has one name, which no other group has."""
    return all(
        given(one) != '' and (given(one) == given(two)) == (groups[one] == groups[two])
        for one in members
        for two in members
    )


def _values(configuration: Configuration, names: Sequence[str]) -> dict[str, Any]:
    values = configuration.as_dict()
    return {name: values.get(name) for name in names}


def _algorithm(configuration: Configuration) -> str:
    """Name an algorithm, and the optimizer where it is not the paper's."""
    name = _readable(configuration.algorithm)
    if configuration.optimizer == 'one_plus_one':
        return name
    return f'{name}, {configuration.optimizer.replace("_", "-").upper()}'


def _setting(configuration: Configuration, differing: Sequence[str]) -> list[str]:
    """Say in which world episodes are played, and what was set otherwise than in it."""
    usual = {name: option.default for name, option in OPTIONS.items()}
    usual |= WORLDS[configuration.world]
    own = [name for name in differing if getattr(configuration, name) != usual[name]]
    return [configuration.world, *_phrases(configuration, own)]


def _phrases(configuration: Configuration, names: Sequence[str]) -> list[str]:
    """Say what some fields are, as in 'wall friction 0.25'."""
    found = []
    for name, value in configuration.as_dict().items():
        if name not in names:
            continue
        text = f'{value:g}' if isinstance(value, float) else str(value)
        found.append(f'{name.replace("_", " ")} {text}')
    return found


def _readable(name: str) -> str:
    text = name.replace('_', ' ')
    return text[:1].upper() + text[1:]

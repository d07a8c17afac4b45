"""Every field of a configuration: those of every run, and those that plug-ins declare."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from coevo_manager.core.configuration import FIELDS
from coevo_manager.core.evolution import algorithms, optimizers, registry
from marxbot_sim.core.fields import Option


def all_fields() -> dict[str, Option]:
    """Return every field by name; `algorithm` and `optimizer` have their choices.

    Raises
    ------
    ValueError
        A plug-in cannot be loaded, or declares a field that is another's.
    """
    fields = {
        **FIELDS,
        'algorithm': dataclasses.replace(FIELDS['algorithm'], choices=tuple(algorithms.names())),
        'optimizer': dataclasses.replace(FIELDS['optimizer'], choices=tuple(optimizers.names())),
    }
    for package in (algorithms, optimizers):
        for option in _declared(package, package.names()):
            if option.name in fields:
                raise ValueError(f'{option.help}: its name, {option.name}, is taken')
            fields[option.name] = option
    return fields


def own_fields(algorithm: str, optimizer: str) -> dict[str, Option]:
    """Return the fields that an algorithm and an optimizer declare, by name."""
    options = (*_declared(algorithms, [algorithm]), *_declared(optimizers, [optimizer]))
    return {option.name: option for option in options}


def _declared(package: Any, names: Iterable[str]) -> Iterator[Option]:
    kind = registry.kind_of(package)
    for name in names:
        for option in package.load(name).parameters:
            yield dataclasses.replace(option, help=f'{kind} {name}: {option.help}')

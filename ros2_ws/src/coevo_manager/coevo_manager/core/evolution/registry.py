"""Plug-ins found by name: those of this tree, and those that installed packages declare.

One of this tree is the one class in one file of a package, named as the file. One from outside is
an entry point of the group ``coevo_manager.algorithms`` or ``coevo_manager.optimizers``: its name
is the plug-in's, its object the class.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from importlib import metadata
from types import ModuleType
from typing import TypeVar

from marxbot_sim.core.fields import check_choice

T = TypeVar('T')


def kind_of(package: ModuleType) -> str:
    """Return what the plug-ins of a package are: 'algorithm' or 'optimizer'."""
    return package.__name__.rpartition('.')[2].removesuffix('s')


def names(package: ModuleType) -> list[str]:
    """Return the names of all plug-ins, sorted."""
    return sorted({*_of_this_tree(package), *_from_outside(kind_of(package))})


def load(package: ModuleType, name: str, base: type[T]) -> type[T]:
    """Return the plug-in of that name, a subclass of ``base``.

    Raises
    ------
    ValueError
        There is none, or that of another package cannot be loaded or is no such class.
    """
    kind = kind_of(package)
    check_choice(kind, name, names(package))
    if name not in _of_this_tree(package):
        return _load_from_outside(_from_outside(kind)[name], kind, base)
    module = importlib.import_module(f'{package.__name__}.{name}')
    (plugin,) = (
        member
        for member in vars(module).values()
        if isinstance(member, type)
        and issubclass(member, base)
        and member.__module__ == module.__name__
    )
    return plugin


@functools.cache
def _of_this_tree(package: ModuleType) -> list[str]:
    return [module.name for module in pkgutil.iter_modules(package.__path__)]


@functools.cache
def _from_outside(kind: str) -> dict[str, metadata.EntryPoint]:
    found = metadata.entry_points(group=f'coevo_manager.{kind}s')
    return {entry_point.name: entry_point for entry_point in found}


def _load_from_outside(entry_point: metadata.EntryPoint, kind: str, base: type[T]) -> type[T]:
    try:
        plugin = entry_point.load()
    except Exception as error:
        raise ValueError(
            f'{kind} {entry_point.name} cannot be loaded from {entry_point.value}: {error}'
        ) from error
    if not (isinstance(plugin, type) and issubclass(plugin, base)):
        raise ValueError(
            f'{kind} {entry_point.name} is {entry_point.value}, expected a subclass of '
            f'{base.__name__}'
        )
    return plugin

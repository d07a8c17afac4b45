"""Plug-ins found by name: one class in one file of a package, named as the file."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType
from typing import TypeVar

from marxbot_sim.core.fields import check_choice

T = TypeVar('T')


def names(package: ModuleType) -> list[str]:
    """Return the names of the plug-ins in a package: its modules, sorted."""
    return sorted(module.name for module in pkgutil.iter_modules(package.__path__))


def load(package: ModuleType, name: str, base: type[T]) -> type[T]:
    """Return the one subclass of ``base`` that the package's module ``name`` defines.

    Raises
    ------
    ValueError
        No such module.
    """
    kind = package.__name__.rpartition('.')[2].removesuffix('s')
    check_choice(kind, name, names(package))
    module = importlib.import_module(f'{package.__name__}.{name}')
    (plugin,) = (
        member
        for member in vars(module).values()
        if isinstance(member, type)
        and issubclass(member, base)
        and member.__module__ == module.__name__
    )
    return plugin

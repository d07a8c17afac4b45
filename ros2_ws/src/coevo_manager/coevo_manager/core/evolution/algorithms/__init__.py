"""Algorithms by name: one file each, found here by the file's name."""

import sys

from coevo_manager.core.evolution import registry
from coevo_manager.core.evolution.algorithm import Algorithm

__all__ = ['load', 'names']


def names() -> list[str]:
    """Return the names of all algorithms."""
    return registry.names(sys.modules[__name__])


def load(name: str) -> type[Algorithm]:
    """Return the algorithm of that name; ValueError if there is none."""
    return registry.load(sys.modules[__name__], name, Algorithm)  # type: ignore[type-abstract]

"""The episode kernel as the analysis uses it, and its version for what is stored."""

import hashlib
import importlib.util
from pathlib import Path

import numpy as np

from coevo_manager.core.episodes import Environment, evaluate_pairs, measure_pairs
from coevo_manager.core.episodes.trace import Trace, trace_pair

SOURCES = (
    'simd_lanes',
    'marxbot_sim.core',
    'neuro_controller.core',
    'coevo_manager.core.environment',
    'coevo_manager.core.episodes',
)
"""Modules and packages, each with all its modules, that decide an episode's course: whatever
``coevo_manager.core.episodes`` imports, directly or not, is among them."""


class Kernel:
    """Plays episodes in the calling thread, without holding the interpreter's lock.

    Attributes
    ----------
    version : str
        Hash of the sources that decide an episode's course: results of other versions are not
        reused.
    """

    def __init__(self) -> None:
        self.version = source_hash()

    def ticks(self, predators, prey, predator_index, prey_index, environment: Environment):
        """Capture ticks int32 (n,) of the given pairs."""
        return evaluate_pairs(predators, prey, predator_index, prey_index, environment)

    def measure(self, predators, prey, predator_index, prey_index, environment: Environment):
        """Capture ticks int32 (n,) and complexity float32 (n, 2), predator and prey."""
        return measure_pairs(predators, prey, predator_index, prey_index, environment)

    def trace(self, predator: np.ndarray, prey: np.ndarray, environment: Environment) -> Trace:
        """Everything that happens in one episode."""
        return trace_pair(predator, prey, environment)


def source_hash() -> str:
    """Hash the sources that decide an episode's course."""
    digest = hashlib.sha256()
    for name in SOURCES:
        origin = Path(importlib.util.find_spec(name).origin)
        for path in sorted(origin.parent.glob('*.py')) if origin.stem == '__init__' else [origin]:
            digest.update(path.name.encode() + b'\0' + path.read_bytes())
    return digest.hexdigest()[:16]

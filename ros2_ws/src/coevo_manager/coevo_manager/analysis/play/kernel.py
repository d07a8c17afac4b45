"""The episode kernel as the analysis uses it, and its version for what is stored."""

import ast
import hashlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from coevo_manager.core.episodes import Environment, evaluate_pairs, measure_pairs, trace_pairs
from coevo_manager.core.episodes.trace import Trace

PLAYS = 'coevo_manager.core.episodes'
"""The package that plays episodes."""

PACKAGES = ('coevo_manager', 'marxbot_sim', 'neuro_controller', 'simd_lanes')
"""The project's packages that it may import."""


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

    def ticks(
        self,
        predators: np.ndarray,
        prey: np.ndarray,
        predator_index: np.ndarray,
        prey_index: np.ndarray,
        environment: Environment,
    ) -> np.ndarray:
        """Capture ticks int32 (n,) of the given pairs."""
        return evaluate_pairs(predators, prey, predator_index, prey_index, environment)

    def measure(
        self,
        predators: np.ndarray,
        prey: np.ndarray,
        predator_index: np.ndarray,
        prey_index: np.ndarray,
        environment: Environment,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Capture ticks int32 (n,) and complexity float32 (n, 2), predator and prey."""
        return measure_pairs(predators, prey, predator_index, prey_index, environment)

    def traces(
        self,
        predators: np.ndarray,
        prey: np.ndarray,
        predator_index: np.ndarray,
        prey_index: np.ndarray,
        environment: Environment,
    ) -> Iterator[Trace]:
        """Yield everything that happens in the episodes of the given pairs."""
        return trace_pairs(predators, prey, predator_index, prey_index, environment)


def source_hash() -> str:
    """Hash the sources that decide an episode's course."""
    digest = hashlib.sha256()
    for name, path in sources().items():
        digest.update(name.encode() + b'\0' + path.read_bytes())
    return digest.hexdigest()[:16]


def sources() -> dict[str, Path]:
    """Return the project's modules that play episodes, by name: all that `PLAYS` imports.

    Imports are followed in the sources, so that no list has to be kept and nothing is loaded.
    """
    found: dict[str, Path] = {}
    waiting = [PLAYS]
    while waiting:
        name = waiting.pop()
        path = None if name in found else _source(name)
        if path is None:
            continue
        found[name] = path
        waiting.append(name.rpartition('.')[0])
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.Import):
                waiting += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                waiting.append(node.module)
                waiting += [f'{node.module}.{alias.name}' for alias in node.names]
    return dict(sorted(found.items()))


def _source(name: str) -> Path | None:
    """Return the file of a module of the project; None for other modules and other names."""
    package, *rest = name.split('.')
    spec = importlib.util.find_spec(package) if package in PACKAGES else None
    if spec is None or spec.origin is None:
        return None
    stem = Path(spec.origin).parent.joinpath(*rest)
    return next((p for p in (stem / '__init__.py', stem.with_suffix('.py')) if p.is_file()), None)

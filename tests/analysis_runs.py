"""Tiny real runs for tests of the analysis."""

from pathlib import Path

from coevo_manager.core.evolution import Evolution, load_configuration
from coevo_manager.core.local_evaluator import LocalEvaluator

TINY = {
    'population': 8,
    'selected': 2,
    'phases': 4,
    'generations': 10,
    'swap_generations': 10,
    'snapshot_generations': 10,
    'episode_ticks': 150,
}
"""A run of a fraction of a second, with snapshots of generations 0, 10, 20, 30 and 40."""


def make_run(folder: Path, condition: str = '', **values) -> Path:
    """Evolve a tiny run with some configuration values of its own."""
    configuration = load_configuration({**TINY, **values})
    evaluator = LocalEvaluator(configuration.make_environment())
    Evolution(configuration, evaluator, folder, condition=condition).run()
    return folder

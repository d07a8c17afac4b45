"""Tiny real runs for tests of the analysis, and a reference of complexity."""

from pathlib import Path

import numpy as np

from coevo_manager.core.configuration import load_configuration
from coevo_manager.core.evaluation import LocalEvaluator
from coevo_manager.core.evolution import Evolution

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


def make_run(folder: Path, **values) -> Path:
    """Evolve a tiny run with some configuration values of its own."""
    configuration = load_configuration({**TINY, **values})
    Evolution(configuration, LocalEvaluator(configuration.make_environment()), folder).run()
    return folder


def complexity_of_wheels(wheels):
    """Behavioural complexity c (section 4) of desired wheel speeds (s, 2): left, right, rad/s.

    With tv = (left + right) / 2 and rv = (right - left) / 2, c is the sum over the s ticks of
    |change of tv| + |change of rv|, starting from rest, over 2 s. Unit: rad/s a tick.
    """
    wheels = np.vstack([np.zeros((1, 2)), np.asarray(wheels, float)])
    translation = (wheels[:, 0] + wheels[:, 1]) / 2
    rotation = (wheels[:, 1] - wheels[:, 0]) / 2
    steps = len(wheels) - 1
    return float((np.abs(np.diff(translation)) + np.abs(np.diff(rotation))).sum() / (2 * steps))

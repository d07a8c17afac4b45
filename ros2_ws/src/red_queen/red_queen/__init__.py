"""Red Queen as a library: what a notebook needs, from one import.

Everything but pictures (Matplotlib), `analyze` and `red_queen.environments` needs NumPy and Numba
alone. The names are those of the packages in which they live; nothing here is another way to do
what they do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from coevo_manager import __version__
from coevo_manager.analysis.runs import Replication, read_run
from coevo_manager.core.configuration import Configuration
from coevo_manager.core.environment import Environment, make_environment
from coevo_manager.core.episodes import (
    evaluate_matrix,
    evaluate_pairs,
    fitness,
    measure_pairs,
    trace_pair,
    trace_pairs,
)
from coevo_manager.core.episodes.trace import Trace
from coevo_manager.core.evolution import GenerationStats, Outcome, PhaseStats, RunFolderError
from coevo_manager.core.species import SPECIES
from coevo_manager.core.worlds import WORLDS
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.champions import Champion, select_champion
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.snapshot import Snapshot, read_snapshot
from red_queen.evolving import evolve, resume
from red_queen.pictures import animate_chase, plot_chase

if TYPE_CHECKING:
    from coevo_manager.analysis.pipeline import analyze

__all__ = [
    'SPECIES',
    'WORLDS',
    'Champion',
    'Configuration',
    'Environment',
    'GenerationStats',
    'Outcome',
    'Perturbations',
    'PhaseStats',
    'Replication',
    'RunFolderError',
    'Snapshot',
    'Trace',
    '__version__',
    'analyze',
    'animate_chase',
    'evaluate_matrix',
    'evaluate_pairs',
    'evolve',
    'fitness',
    'make_environment',
    'measure_pairs',
    'plot_chase',
    'random_genomes',
    'read_run',
    'read_snapshot',
    'resume',
    'select_champion',
    'trace_pair',
    'trace_pairs',
]


def __getattr__(name: str) -> Any:
    """Load `analyze`, which needs many libraries, when it is asked for."""
    if name == 'analyze':
        from coevo_manager.analysis.pipeline import analyze

        return analyze
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')

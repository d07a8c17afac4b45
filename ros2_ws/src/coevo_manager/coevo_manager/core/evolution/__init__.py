"""Co-evolution of predators and prey, without ROS."""

from coevo_manager.core.evolution.evolution import Evolution
from coevo_manager.core.evolution.loading import load_configuration, remarks
from coevo_manager.core.evolution.observation import (
    GenerationStats,
    Observer,
    Outcome,
    PhaseStats,
)
from coevo_manager.core.evolution.run_folder import (
    RunFolderError,
    check_new_folder,
    read_configuration,
    read_record,
)

__all__ = [
    'Evolution',
    'GenerationStats',
    'Observer',
    'Outcome',
    'PhaseStats',
    'RunFolderError',
    'check_new_folder',
    'load_configuration',
    'read_configuration',
    'read_record',
    'remarks',
]

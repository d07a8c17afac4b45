"""Episodes between predators and prey: the kernel and what plays its requests."""

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.play import (
    EpisodeStream,
    evaluate_matrix,
    evaluate_pairs,
    fitness,
    measure_pairs,
    trace_pair,
)
from coevo_manager.core.episodes.traces import trace_pairs

__all__ = [
    'Environment',
    'EpisodeStream',
    'evaluate_matrix',
    'evaluate_pairs',
    'fitness',
    'measure_pairs',
    'trace_pair',
    'trace_pairs',
]

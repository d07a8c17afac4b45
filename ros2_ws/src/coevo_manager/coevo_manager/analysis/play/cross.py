"""Cross-experiment test (section 3, Fig. 4): one condition's agents, another's opponents."""

import numpy as np

from coevo_manager.analysis.study import Replications, Study


def cross_values(
    each: Replications, other: Replications, species: str, study: Study
) -> np.ndarray:
    """Fitness (R,) of each run's last agents against another condition's, own run left out."""
    values = []
    for run in each.runs:
        cells = [_cross_cell(study, run, q, species) for q in other.runs if q is not run]
        values.append(np.mean(cells) if cells else np.nan)
    return np.array(values)


def paper_cross_values(each: Replications, other: Replications, species: str, study) -> np.ndarray:
    """As `cross_values` with a run's own opponents among its condition's, as the paper has it."""
    return np.array(
        [np.mean([_cross_cell(study, run, q, species) for q in other.runs]) for run in each.runs]
    )


def _cross_cell(study: Study, run, other, species: str) -> float:
    if species == 'predator':
        return study.cross[run.folder, other.folder]
    return 1.0 - study.cross[other.folder, run.folder]

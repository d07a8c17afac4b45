"""Cross-experiment test (section 3, Fig. 4): one condition's agents, another's opponents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np


def cross_values(
    agents: Sequence[Path],
    opponents: Sequence[Path],
    species: str,
    cross: Mapping[tuple[Path, Path], float],
    own: bool,
) -> np.ndarray:
    """Fitness (R,) of each run's last agents against those of a condition.

    Parameters
    ----------
    agents, opponents : sequence of Path
        Folders of the runs, R of agents.
    cross : mapping of (predators' run, prey's run) to float
        Mean predator fitness between last generations.
    own : bool
        Whether a run's own opponents count among its condition's, as in the paper. They co-evolved
        with it; without them, NaN where nothing is left.
    """
    values = []
    for run in agents:
        cells = [_cell(run, other, species, cross) for other in opponents if own or other != run]
        values.append(np.mean(cells) if cells else np.nan)
    return np.array(values)


def _cell(run: Path, other: Path, species: str, cross: Mapping[tuple[Path, Path], float]) -> float:
    return cross[run, other] if species == 'predator' else 1.0 - cross[other, run]

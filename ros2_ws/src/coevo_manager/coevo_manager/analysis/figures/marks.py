"""Curves, names and layout that the figures share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from coevo_manager.analysis.figures.charts import (
    CONDITION_COLOURS,
    CONDITION_MARKERS,
    MARKERS,
    Line,
    Panel,
)
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.study import ConditionResults
from coevo_manager.core.species import COLOURS, PLURAL


def interval_note(members: Sequence[ConditionResults], what: str = 'Bands') -> str:
    """Say what bands (or bars) are, or that there are none."""
    counts = sorted({len(each.runs) for each in members})
    if counts[-1] < 2:
        return 'One replication: no intervals.'
    of = f'{counts[0]}' if len(counts) == 1 else f'{counts[0]} to {counts[-1]}'
    return f'{what}: 95 % bootstrap intervals of the mean over {of} replications.'


def species_line(x: ArrayLike, values: ArrayLike, species: str, name: str | None = None) -> Line:
    """Mean over replications (R, S) of one species, with its interval where there are several."""
    line = Line(
        x,
        (),
        name or PLURAL[species].capitalize(),
        COLOURS[species],
        dashed=species == 'prey',
        marker=MARKERS[species],
    )
    return _with_mean(line, values)


def condition_line(
    x: ArrayLike,
    values: ArrayLike,
    each: ConditionResults,
    members: Sequence[ConditionResults],
) -> Line:
    """As `species_line`, in a condition's colour and marker."""
    place = [other.condition for other in members].index(each.condition)
    line = Line(
        x,
        (),
        each.condition.name,
        CONDITION_COLOURS[place % len(CONDITION_COLOURS)],
        marker=CONDITION_MARKERS[place % len(CONDITION_MARKERS)],
    )
    return _with_mean(line, values)


def _with_mean(line: Line, values: ArrayLike) -> Line:
    """Give a line the mean of (R, S) and its interval; runs without a value (NaN) do not count."""
    table = np.asarray(values, float)
    known = np.isfinite(table).any(axis=0)
    mean = np.full(table.shape[1], np.nan)
    mean[known] = np.nanmean(table[:, known], axis=0)
    line.y = mean
    if len(table) > 1:
        line.low, line.high = statistics.bootstrap_interval(table.T)
    return line


def in_rows(panels: list[Panel], columns: int = 3) -> list[list[Panel]]:
    """Lay panels out in rows."""
    return [panels[start : start + columns] for start in range(0, len(panels), columns)]


def compact(rows: list[list[Panel]]) -> list[list[Panel]]:
    """Lay rows of one panel side by side."""
    return in_rows([row[0] for row in rows]) if all(len(row) == 1 for row in rows) else rows

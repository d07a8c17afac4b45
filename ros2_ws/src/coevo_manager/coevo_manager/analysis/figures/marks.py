"""Curves, names and layout that the figures share."""

import numpy as np

from coevo_manager.analysis.figures.charts import (
    CONDITION_COLOURS,
    CONDITION_MARKERS,
    MARKERS,
    Line,
    Panel,
)
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.study import Replications
from coevo_manager.core.species import COLOURS, PLURAL

INTERVAL = 'Bands and bars: 95 % bootstrap intervals of the mean over replications.'


def slug_of(arena: str) -> str:
    """An environment's name in file names."""
    return arena.replace(',', '').replace(' ', '_')


def label(condition, members: list[Replications]) -> dict:
    """Colour and marker of a condition among those of its environment."""
    place = [each.condition for each in members].index(condition)
    return {
        'colour': CONDITION_COLOURS[place % len(CONDITION_COLOURS)],
        'marker': CONDITION_MARKERS[place % len(CONDITION_MARKERS)],
    }


def species_line(x, values, species: str, name: str | None = None) -> Line:
    """Mean over replications (R, S) of one species, with its interval where there are several."""
    values = np.asarray(values, float)
    line = Line(
        x,
        values.mean(axis=0),
        name or PLURAL[species].capitalize(),
        COLOURS[species],
        dashed=species == 'prey',
        marker=MARKERS[species],
    )
    if len(values) > 1:
        line.low, line.high = statistics.bootstrap_interval(values.T)
    return line


def condition_line(x, values, each: Replications, members: list[Replications]) -> Line:
    """As `species_line`, in a condition's colour and marker."""
    values = np.asarray(values, float)
    line = Line(x, values.mean(axis=0), each.condition.name, **label(each.condition, members))
    if len(values) > 1:
        line.low, line.high = statistics.bootstrap_interval(values.T)
    return line


def in_rows(panels: list[Panel], columns: int = 3) -> list[list[Panel]]:
    """Lay panels out in rows."""
    return [panels[start : start + columns] for start in range(0, len(panels), columns)]


def compact(rows: list[list[Panel]]) -> list[list[Panel]]:
    """Lay rows of one panel side by side."""
    return in_rows([row[0] for row in rows]) if all(len(row) == 1 for row in rows) else rows

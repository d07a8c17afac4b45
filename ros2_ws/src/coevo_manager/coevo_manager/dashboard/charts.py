"""Charts of runs that go on or have ended, one beside the other or one by itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from coevo_manager.analysis.figures.charts import (
    CONDITION_COLOURS,
    MARKERS,
    Chart,
    Heat,
    Line,
    Mark,
    Panel,
    Spans,
)
from coevo_manager.analysis.figures.interactive import chart_data
from coevo_manager.analysis.logs import turns
from coevo_manager.core.species import COLOURS, PLURAL, SPECIES
from coevo_manager.dashboard.watched import WatchedRun

POINTS = 400
"""A curve has at most so many; each is the mean of the generations or phases around it."""

BY_RUN = 'run'
"""Field that each run has for itself."""

_PALETTE = CONDITION_COLOURS[1:]  # black is not seen on a dark page

Curve = Callable[[WatchedRun], tuple[np.ndarray, np.ndarray]]


def run_charts(runs: Sequence[WatchedRun], field: str) -> dict[str, Any]:
    """Return a chart for `charts.js`: fitness, retained agents and acceptance over generations.

    Parameters
    ----------
    runs : sequence of WatchedRun
    field : str
        Runs that agree in this field of their configuration have one colour; `BY_RUN` tells each
        from all others.
    """
    panels = [
        _panel(
            'Fitness of the evolving (predators; prey 1 minus it)',
            'Predator fitness',
            _evolving,
            runs,
            field,
            (0.0, 1.0),
        ),
        _populations(runs, field),
        _panel('Agents retained by a phase', 'Agents', _retained, runs, field),
        _panel('Acceptance rate', 'Share of the agents', _accepted, runs, field),
    ]
    chart = Chart('runs', 'Runs', '', [panels[:2], panels[2:]], height=1.6)
    return chart_data(chart)


def tournament_chart(
    generations: Sequence[int], fitness: np.ndarray, complexity: np.ndarray
) -> dict[str, Any]:
    """Return a chart for `charts.js`: who beats whom, and how complex what they do is.

    Parameters
    ----------
    generations : sequence of int, length G
    fitness : float array, shape (G, G)
        Of the predators of a generation (row) against the prey of another; NaN where unknown.
    complexity : float array, shape (G, 2)
        Of predators and prey among contemporaries, rad/s per tick; NaN where unknown.
    """
    lines: list[Mark] = [
        Line(
            generations,
            complexity[:, k],
            PLURAL[species].capitalize(),
            COLOURS[species],
            dashed=species == 'prey',
            marker=MARKERS[species],
        )
        for k, species in enumerate(SPECIES)
    ]
    heat = Heat(generations, generations, fitness, 'Predator fitness')
    panels = [
        Panel('Master tournament', 'Generation of prey', 'Generation of predators', [heat]),
        Panel('Complexity among contemporaries', 'Generation', 'rad/s per tick', lines, zero=True),
    ]
    return chart_data(Chart('tournament', 'Master tournament', '', [panels], height=2.6))


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return at most `POINTS` points, means over neighbours."""
    if len(x) <= POINTS:
        return x, y
    bounds = np.linspace(0, len(x), POINTS + 1).astype(int)
    counts = np.diff(bounds)
    return tuple(np.add.reduceat(values, bounds[:-1]) / counts for values in (x, y))  # type: ignore[return-value]


def _columns(table: pd.DataFrame, *names: str) -> tuple[np.ndarray, ...]:
    return tuple(table[name].to_numpy(float) for name in names)


def _evolving(run: WatchedRun) -> tuple[np.ndarray, np.ndarray]:
    table = run.generations.table
    generation, fitness = _columns(table, 'generation', 'fitness_mean')
    return generation, np.where(table['evolving'] == 'predator', fitness, 1 - fitness)


def _accepted(run: WatchedRun) -> tuple[np.ndarray, np.ndarray]:
    generation, accepted = _columns(run.generations.table, 'generation', 'accepted')
    return generation, accepted / run.configuration.selected


def _retained(run: WatchedRun) -> tuple[np.ndarray, np.ndarray]:
    generation, retained = _columns(run.phases.table, 'generation', 'retained')
    return generation[1:], retained[1:]


def _predators(run: WatchedRun) -> tuple[np.ndarray, np.ndarray]:
    generation, fitness = _columns(run.phases.table, 'generation', 'predator_fitness')
    return generation, fitness


def _prey(run: WatchedRun) -> tuple[np.ndarray, np.ndarray]:
    generation, fitness = _columns(run.phases.table, 'generation', 'prey_fitness')
    return generation, fitness


def _panel(
    title: str,
    ylabel: str,
    curve: Curve,
    runs: Sequence[WatchedRun],
    field: str,
    ylim: tuple[float, float] | None = None,
) -> Panel:
    marks: list[Mark] = []
    if len(runs) == 1:
        table = runs[0].generations.table
        marks += [
            Spans(turns(table, s), f'{PLURAL[s].capitalize()} evolve', COLOURS[s]) for s in SPECIES
        ]
    for k, (value, members) in enumerate(_groups(runs, field).items()):
        colour = _PALETTE[k % len(_PALETTE)]
        curves = [thinned(*curve(run)) for run in members]
        marks += [
            Line(x, y, value, colour, thin=len(members) > 1, in_legend=len(members) == 1)
            for x, y in curves
        ]
        if len(members) > 1:
            marks.append(Line(*_mean(curves), f'{value}, mean of {len(members)}', colour))
    return Panel(title, 'Generation', ylabel, marks, ylim, zero=ylim is None)


def _populations(runs: Sequence[WatchedRun], field: str) -> Panel:
    title, ylim = 'Fitness of the populations', (0.0, 1.0)
    if len(runs) > 1:
        return _panel(
            f'{title} (predators; prey 1 minus it)', 'Fitness', _predators, runs, field, ylim
        )
    marks: list[Mark] = [
        Line(
            *thinned(*curve(run)),
            PLURAL[species].capitalize(),
            COLOURS[species],
            dashed=species == 'prey',
        )
        for run in runs
        for species, curve in zip(SPECIES, (_predators, _prey), strict=True)
    ]
    return Panel(title, 'Generation', 'Fitness', marks, ylim)


def _groups(runs: Sequence[WatchedRun], field: str) -> dict[str, list[WatchedRun]]:
    """Return the runs by what they are told apart by."""
    groups: dict[str, list[WatchedRun]] = {}
    for run in runs:
        own = field == BY_RUN
        value = run.name if own else f'{field} {run.configuration.as_dict().get(field)}'
        groups.setdefault(value, []).append(run)
    return groups


def _mean(curves: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of curves as far as all have come, between their points by lines."""
    known = [(x, y) for x, y in curves if len(x)]
    if len(known) < len(curves):
        return np.empty(0), np.empty(0)
    grid = np.linspace(max(x[0] for x, _ in known), min(x[-1] for x, _ in known), POINTS)
    return grid, np.mean([np.interp(grid, x, y) for x, y in known], axis=0)

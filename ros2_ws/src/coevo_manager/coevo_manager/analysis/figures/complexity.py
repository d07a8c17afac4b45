"""Complexity and kind of behaviour over generations and against performance (Figs. 6 and 7)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from coevo_manager.analysis.figures.charts import MARKERS, Chart, Panel, Points
from coevo_manager.analysis.figures.draw import thousands
from coevo_manager.analysis.figures.marks import condition_line, in_rows, interval_note
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.play.behaviours import AGENTS, OPPONENTS
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import COLOURS, PLURAL, SPECIES

UNIT = 'c (rad/s per tick)'
MEASURED = {
    'reversals': 'Reversals in 100 s',
    'forward': 'Time forward',
    'backward': 'Time backward',
    'turning': 'Time turning',
    'pausing': 'Time pausing',
}
"""Labels of the measures of behaviour, apart from complexity; times are shares."""

HOW = (
    f'{AGENTS} individuals of every rank met {OPPONENTS} opponents each, with sensors without '
    'noise. Only episodes that no capture ended count; they are of equal length.'
)

Members = Sequence[ConditionResults]


def complexity_figures(arena: str, members: Members, study: Study) -> Iterator[Chart]:
    """Fig. 6 as the paper has it and without what disturbs it, behaviours, and Fig. 7."""
    yield _complexity(arena, members, study)
    yield _quiet_complexity(arena, members, study)
    yield _behaviour(arena, members, study)
    yield _correlation(arena, members, study)


def _complexity(arena: str, members: Members, study: Study) -> Chart:
    panels = []
    for species in SPECIES:
        marks = []
        for each in members:
            values = each.complexity[species]
            line = condition_line(study.generations, values, each, members)
            if len(each.runs) > 1:
                error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
                line.low, line.high = line.y - error, line.y + error
            marks.append(line)
        panels.append(
            Panel(PLURAL[species].capitalize(), 'Generation', f'Complexity {UNIT}', marks)
        )
    return Chart(
        'complexity',
        f'Behavioural complexity, {arena}',
        'The curves are the mean complexity c of the behaviour of all agents against all '
        'opponents of the same generation (Fig. 6). It is half the mean, over the ticks of an '
        'episode, of the change of desired translational plus rotational wheel speed.',
        [panels],
        arena,
        'Bands: standard errors over replications, as in the paper.'
        if max(len(each.runs) for each in members) > 1
        else 'One replication: no intervals.',
    )


def _quiet_complexity(arena: str, members: Members, study: Study) -> Chart:
    rows: list[list[Panel]] = []
    for faced, title in (('contemporaries', 'own generation'), ('fixed', 'last generation')):
        row = []
        for species in SPECIES:
            marks = [
                condition_line(
                    study.generations, each.behaviour[faced][species]['complexity'], each, members
                )
                for each in members
            ]
            name = f'{PLURAL[species].capitalize()} vs best of the {title}'
            row.append(Panel(name, 'Generation', f'Complexity {UNIT}', marks))
        rows.append(row)
    return Chart(
        'complexity_quiet',
        f'Complexity without noise, {arena}',
        'This is complexity c beside Fig. 6, without what hides it: sensor noise, captures and '
        f'changing opponents. {HOW} Above, opponents are of the same generation. Below, they are '
        'the same for all generations: the best of the last.',
        rows,
        arena,
        interval_note(members),
        height=1.8,
    )


def _behaviour(arena: str, members: Members, study: Study) -> Chart:
    rows: list[list[Panel]] = []
    for measure, label in MEASURED.items():
        row = []
        for species in SPECIES:
            marks = [
                condition_line(
                    study.generations, each.behaviour['fixed'][species][measure], each, members
                )
                for each in members
            ]
            title = PLURAL[species].capitalize() if not rows else ''
            limits = None if measure == 'reversals' else (-0.02, 1.02)
            row.append(Panel(title, 'Generation', label, marks, limits))
        rows.append(row)
    return Chart(
        'behaviour',
        f'What the robots do, {arena}',
        'The rows are changes of driving direction, and shares of time: driving forward or '
        'backward (mean wheel speed of at least 1 rad/s), turning on the spot and pausing. '
        f'{HOW} The opponents are the best of the last generation, for all generations.',
        rows,
        arena,
        interval_note(members),
        height=1.25,
    )


def _correlation(arena: str, members: Members, study: Study) -> Chart:
    panels = []
    ends = [np.inf, -np.inf]
    for each in members:
        marks, notes = [], []
        for species in SPECIES:
            fitness = performance(each.tournament, species)[:, :, -1].mean(axis=0)
            complexity = each.complexity[species].mean(axis=0)
            ends = [min(ends[0], complexity.min()), max(ends[1], complexity.max())]
            marks.append(
                Points(
                    complexity,
                    fitness,
                    PLURAL[species].capitalize(),
                    COLOURS[species],
                    MARKERS[species],
                    [thousands(g) for g in study.generations],
                    path=True,
                )
            )
            r, p, low, high = statistics.correlation(complexity, fitness)
            if np.isfinite(r):
                size = 'p < 0.001' if p < 0.001 else f'p = {p:.3f}'
                between = f' [{low:.2f}, {high:.2f}]' if np.isfinite(low) else ''
                notes.append(f'{PLURAL[species]}: r = {r:.2f}{between},\n{size}')
        panels.append(
            Panel(
                each.condition.name,
                f'Complexity {UNIT}',
                'Fitness vs last opponents',
                marks,
                (0, 1.7),
                note='\n'.join(notes),
            )
        )
    margin = 0.06 * (ends[1] - ends[0]) or 0.1
    for panel in panels:
        panel.xlim = (ends[0] - margin, ends[1] + margin)
    return Chart(
        'complexity_correlation',
        f'Performance and complexity, {arena}',
        'Each point is one generation, averaged over replications. It shows the complexity of '
        'behaviour and the performance against the last generation (Fig. 7). Generations of a '
        'run are not independent: p is too small, and the table has correlations within each '
        'replication.',
        in_rows(panels),
        arena,
        'Points grow from the first generation to the last. Brackets: 95 % interval of r.',
    )

"""The paper's figures of fitness and progress (sections 3 and 5), made from a study."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from coevo_manager.analysis.conditions import without_obstacle
from coevo_manager.analysis.figures.charts import Bars, Chart, Heat, Line, Mark, Panel, Spans
from coevo_manager.analysis.figures.complexity import complexity_figures
from coevo_manager.analysis.figures.marks import compact, in_rows, interval_note, species_line
from coevo_manager.analysis.logs import turns
from coevo_manager.analysis.measures import paper as measures
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.measures.cross import cross_values
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import COLOURS, OTHER, PLURAL, SPECIES

WINDOW = 5000  # generations shown of the beginning and of the end (Fig. 1)

Members = Sequence[ConditionResults]


def paper_figures(study: Study) -> Iterator[Chart]:
    """Charts of Figs. 1-4 and 6-9, and CIAO plots; arenas apart."""
    for arena, members in study.arenas().items():
        yield _evolving(arena, members)
        yield _populations(arena, members)
        yield _tournament(arena, members, study)
        yield _ciao(arena, members, study)
        yield _progress(arena, members, study)
        if len(members) > 1:
            yield _cross(arena, members, study)
        yield from complexity_figures(arena, members, study)
    yield from _obstacle(study)


def _evolving(arena: str, members: Members) -> Chart:
    rows = []
    for each in members:
        table = each.runs[0].table('generations')
        last = int(table['generation'].max())
        windows = [(0, last)] if last <= 2 * WINDOW else [(0, WINDOW), (last - WINDOW, last)]
        row = []
        for start, end in windows:
            part = table[(table['generation'] >= start) & (table['generation'] <= end)]
            fitness = np.where(
                part['evolving'] == 'predator', part['fitness_mean'], 1 - part['fitness_mean']
            )
            marks: list[Mark] = [
                Spans(turns(part, s), f'{PLURAL[s].capitalize()} evolve', COLOURS[s])
                for s in SPECIES
            ]
            line = Line(part['generation'].to_numpy(), fitness, 'Predator fitness', '#222222')
            when = '' if len(windows) == 1 else ', first' if start == 0 else ', last'
            title = f'{each.condition.name}{when}'
            row.append(
                Panel(
                    title, 'Generation', 'Predator fitness', [*marks, line], (0, 1), (start, end)
                )
            )
        rows.append(row)
    return Chart(
        'fitness_evolving',
        f'Fitness of the evolving robots, {arena}',
        'The curve is the mean fitness of the predators among the n agents and their n opponents '
        'during each phase, in the first replication (Fig. 1); that of the prey is 1 minus it. '
        'It climbs while predators evolve and falls while prey evolve. Jumps are new selections '
        'of agents and opponents. Improving against current opponents is not yet progress.',
        rows,
        arena,
        'Fitness of the prey: 1 minus the curve.',
        height=1.7,
    )


def _populations(arena: str, members: Members) -> Chart:
    panels = []
    for each in members:
        tables = [run.table('phases') for run in each.runs]
        length = min(len(table) for table in tables)
        generation = tables[0]['generation'].to_numpy()[:length]
        marks: list[Mark] = []
        for species in SPECIES:
            curves = [table[f'{species}_fitness'].to_numpy() for table in tables]
            looks = (PLURAL[species].capitalize(), COLOURS[species], species == 'prey')
            if len(curves) > 1:
                marks += [
                    Line(table['generation'].to_numpy(), curve, *looks, thin=True, in_legend=False)
                    for table, curve in zip(tables, curves, strict=True)
                ]
            mean = np.mean([curve[:length] for curve in curves], axis=0)
            marks.append(Line(generation, mean, *looks))
        panels.append(Panel(each.condition.name, 'Generation', 'Fitness', marks, (0, 1)))
    return Chart(
        'fitness_populations',
        f'Fitness of the populations, {arena}',
        'The curves are the mean fitness of all N individuals of each population against all N '
        'of the other, after each phase (Fig. 2). Level curves can mean that nobody improves or '
        'that both do: the tournament tells.',
        in_rows(panels),
        arena,
        'Thick: mean over replications. Thin: each replication.',
    )


def _tournament(arena: str, members: Members, study: Study) -> Chart:
    rows: list[list[Panel]] = [[], []]
    for each in members:
        for row, z, what in (
            (0, each.tournament[0], f'seed {each.runs[0].seed}'),
            (1, each.tournament.mean(axis=0), f'mean of {len(each.runs)}'),
        ):
            marks = [Heat(study.generations, study.generations, z, 'Predator fitness')]
            title = f'{each.condition.name},\n{what}'
            rows[row].append(Panel(title, 'Generation of prey', 'Generation of predators', marks))
    several = any(len(each.runs) > 1 for each in members)
    return Chart(
        'master_tournament',
        f'Master tournament, {arena}',
        'The map is the mean fitness of the predators of each generation (rows) against the prey '
        'of each generation (columns), all against all (Figs. 3 and 8). The fitness of the prey '
        'is 1 minus it. Progress of predators makes it brighter upwards along a column. '
        'Progress of prey makes it darker rightwards along a row.',
        compact(rows if several else rows[:1]),
        arena,
        height=2.5,
    )


def _ciao(arena: str, members: Members, study: Study) -> Chart:
    rows = []
    for each in members:
        row = []
        for species in SPECIES:
            z = measures.ciao(each.tournament.mean(axis=0), species)
            row.append(
                Panel(
                    f'{each.condition.name}: {PLURAL[species]}',
                    f'Generation of ancestral {PLURAL[OTHER[species]]}',
                    f'Generation of current {PLURAL[species]}',
                    [Heat(study.generations, study.generations, z, 'Own fitness')],
                )
            )
        rows.append(row)
    return Chart(
        'ciao',
        f'Current individuals against ancestral opponents (CIAO), {arena}',
        'Each generation (row) meets the ancestors of its opponents (columns). The map is the '
        'fitness of the row (Cliff & Miller 1995), as a mean over replications. Historical '
        'progress makes it brighter to the left of the diagonal.',
        rows,
        arena,
        height=2.5,
    )


def _progress(arena: str, members: Members, study: Study) -> Chart:
    x = study.generations
    rows: list[list[Panel]] = [[], []]
    for each in members:
        historical, final = [], []
        for species in SPECIES:
            own = performance(each.tournament, species)
            historical.append(species_line(x, own[:, -1, :], species))
            final.append(species_line(x, own[:, :, -1], species))
        for row, what, xlabel, ylabel, marks in (
            (0, 'historical', 'Generation of opponents', 'Fitness of last agents', historical),
            (1, 'global', 'Generation of agents', 'Fitness vs last opponents', final),
        ):
            title = f'{each.condition.name}: {what}'
            rows[row].append(Panel(title, xlabel, ylabel, marks, (0, 1)))
    return Chart(
        'progress',
        f'Historical and global progress, {arena}',
        'Historical: the last generation meets opponents of every generation, and progress is a '
        'curve that falls to the right. Global: every generation meets the last opponents, and '
        'progress is a curve that rises to the right.',
        compact(rows),
        arena,
        interval_note(members),
        height=1.9,
    )


def _cross(arena: str, members: Members, study: Study) -> Chart:
    panels = []
    groups = [other.condition.name for other in members]
    for each in members:
        own = [run.folder for run in each.runs]
        marks = []
        for species in SPECIES:
            values = np.stack(
                [
                    cross_values(own, [r.folder for r in other.runs], species, study.cross, True)
                    for other in members
                ]
            )
            bars = Bars(
                groups,
                values.mean(axis=1),
                PLURAL[species].capitalize(),
                COLOURS[species],
                hatched=species == 'prey',
            )
            if len(each.runs) > 1:
                bars.low, bars.high = statistics.bootstrap_interval(values)
            marks.append(bars)
        title = f'{each.condition.name} agents'
        panels.append(Panel(title, 'Opponents evolved in', 'Fitness', marks, (0, 1)))
    return Chart(
        'cross_experiment',
        f'Cross-experiment test, {arena}',
        'The last generation of each condition meets the last of every condition (Fig. 4). The '
        'own opponents of a run are included, as in the paper; the table of tests leaves them '
        'out as well. An agent that does better against the opponents of another condition than '
        'against those of its own outperforms that condition.',
        in_rows(panels),
        arena,
        interval_note(members, 'Bars'),
    )


def _obstacle(study: Study) -> Iterator[Chart]:
    """Fig. 9: each condition's normalised curves with and without the obstacle."""
    pairs: dict[object, dict[str, ConditionResults]] = {}
    for each in study.conditions:
        configuration = each.runs[0].configuration
        key = without_obstacle(configuration), each.condition.name
        pairs.setdefault(key, {})[configuration.environment] = each
    found = [both for both in pairs.values() if len(both) == 2]
    if not found:
        return
    for what, xlabel, ylabel in (
        ('historical', 'Generation of opponents', 'Normalised fitness, last agents'),
        ('global', 'Generation of agents', 'Normalised fitness vs last'),
    ):
        rows = []
        for species in SPECIES:
            row = []
            for both in found:
                marks = [
                    _normalised_line(both[environment], species, what, study, environment)
                    for environment in ('open', 'obstacle')
                ]
                title = f'{both["open"].condition.name}: {PLURAL[species]}'
                row.append(Panel(title, xlabel, ylabel, marks, (-0.05, 1.05)))
            rows.append(row)
        yield Chart(
            f'obstacle_comparison_{what}',
            f'{what.capitalize()} progress with and without the obstacle',
            'The curves of mean performance are scaled to [0, 1], each by its own extent (Fig. '
            '9). Their shape can be compared, but not their height.',
            rows,
            height=1.9,
        )


def _normalised_line(
    each: ConditionResults, species: str, what: str, study: Study, environment: str
) -> Line:
    own = performance(each.tournament, species).mean(axis=0)
    curve = own[-1, :] if what == 'historical' else own[:, -1]
    dashed = environment == 'obstacle'
    return Line(
        study.generations,
        measures.normalised(curve),
        'With obstacle' if dashed else 'Open arena',
        '#e69f00' if dashed else '#333333',
        dashed=dashed,
        marker='square' if dashed else 'circle',
    )

"""The paper's figures of fitness and progress (sections 3 and 5), made from a study."""

from collections.abc import Iterator

import numpy as np

from coevo_manager.analysis.figures.charts import Bars, Chart, Heat, Line, Panel
from coevo_manager.analysis.figures.complexity import complexity_figure, correlation_figure
from coevo_manager.analysis.figures.marks import INTERVAL, compact, in_rows, slug_of, species_line
from coevo_manager.analysis.measures import paper as measures
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.play.cross import paper_cross_values
from coevo_manager.analysis.study import Replications, Study
from coevo_manager.core.species import COLOURS, OTHER, PLURAL, SPECIES

WINDOW = 5000  # generations shown of the beginning and of the end (Fig. 1)


def paper_figures(study: Study) -> Iterator[Chart]:
    """Charts of Figs. 1-4 and 6-9, and CIAO plots; environments apart."""
    for arena, members in study.arenas().items():
        slug = slug_of(arena)
        yield _evolving(f'fitness_evolving_{slug}', arena, members)
        yield _populations(f'fitness_populations_{slug}', arena, members)
        yield _tournament(f'master_tournament_{slug}', arena, members, study)
        yield _ciao(f'ciao_{slug}', arena, members, study)
        yield _progress(f'progress_{slug}', arena, members, study)
        if len(members) > 1:
            yield _cross(f'cross_experiment_{slug}', arena, members, study)
        yield complexity_figure(f'complexity_{slug}', arena, members, study)
        yield correlation_figure(f'complexity_correlation_{slug}', arena, members, study)
    yield from _obstacle(study)


def _evolving(name: str, arena: str, members: list[Replications]) -> Chart:
    rows = []
    for each in members:
        table = each.runs[0].table('generations')
        last = int(table['generation'].max())
        windows = [(0, last)] if last <= 2 * WINDOW else [(0, WINDOW), (last - WINDOW, last)]
        row = []
        for start, end in windows:
            part = table[(table['generation'] >= start) & (table['generation'] <= end)]
            predator = np.where(
                part['evolving'] == 'predator', part['fitness_mean'], 1 - part['fitness_mean']
            )
            x = part['generation'].to_numpy()
            marks = [
                Line(x, predator, 'Predators', COLOURS['predator']),
                Line(x, 1 - predator, 'Prey', COLOURS['prey'], dashed=True),
            ]
            when = '' if len(windows) == 1 else ', first' if start == 0 else ', last'
            title = f'{each.condition.name}{when}'
            row.append(Panel(title, 'Generation', 'Fitness', marks, ylim=(0, 1)))
        rows.append(row)
    return Chart(
        name,
        f'Fitness of the evolving robots, {arena}',
        'Mean fitness of the n agents and their n opponents during each phase, first replication '
        '(Fig. 1). The evolving species climbs, the other falls; jumps are new selections of '
        'agents and opponents. Improving against current opponents is not yet progress.',
        rows,
        height=1.7,
    )


def _populations(name: str, arena: str, members: list[Replications]) -> Chart:
    panels = []
    for each in members:
        marks: list = []
        for r, run in enumerate(each.runs):
            table = run.table('phases')
            for species in SPECIES:
                marks.append(
                    Line(
                        table['generation'].to_numpy(),
                        table[f'{species}_fitness'].to_numpy(),
                        PLURAL[species].capitalize(),
                        COLOURS[species],
                        dashed=species == 'prey',
                        thin=r > 0,
                        in_legend=r == 0,
                    )
                )
        panels.append(Panel(each.condition.name, 'Generation', 'Fitness', marks, ylim=(0, 1)))
    return Chart(
        name,
        f'Fitness of the populations, {arena}',
        'Mean fitness of all N individuals of each population against all N of the other, after '
        'each phase (Fig. 2). Thick: first replication; thin: the others. Level curves can mean '
        'that nobody improves or that both do: the tournament tells.',
        in_rows(panels),
    )


def _tournament(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    rows = [[], []]
    for each in members:
        for row, z, what in (
            (0, each.tournament[0], f'seed {each.runs[0].seed}'),
            (1, each.tournament.mean(axis=0), f'mean of {len(each.runs)}'),
        ):
            marks = [Heat(study.generations, study.generations, z, 'Predator fitness')]
            title = f'{each.condition.name}, {what}'
            rows[row].append(Panel(title, 'Generation of prey', 'Generation of predators', marks))
    several = any(len(each.runs) > 1 for each in members)
    return Chart(
        name,
        f'Master tournament, {arena}',
        'Mean fitness of the predators of each generation (rows) against the prey of each '
        'generation '
        "(columns), all against all (Figs. 3 and 8); the prey's is 1 minus it. Progress of "
        'predators: '
        'brighter upwards along a column. Progress of prey: darker rightwards along a row.',
        compact(rows if several else rows[:1]),
        height=2.5,
    )


def _ciao(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    rows = []
    for each in members:
        row = []
        for species in SPECIES:
            z = measures.ciao(each.tournament.mean(axis=0), species)
            marks = [Heat(study.generations, study.generations, z, 'Own fitness')]
            title = f'{each.condition.name}: {PLURAL[species]}'
            row.append(
                Panel(
                    title,
                    f'Generation of ancestral {PLURAL[OTHER[species]]}',
                    f'Generation of current {PLURAL[species]}',
                    marks,
                )
            )
        rows.append(row)
    return Chart(
        name,
        f'Current individuals against ancestral opponents (CIAO), {arena}',
        "Each generation (row) against its opponents' ancestors (columns), in the row's own "
        'fitness '
        '(Cliff & Miller 1995); mean over replications. Historical progress: brighter to the '
        'left of the diagonal.',
        rows,
        height=2.5,
    )


def _progress(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    x = study.generations
    rows = [[], []]
    for each in members:
        historical, final = [], []
        for species in SPECIES:
            own = performance(each.tournament, species)
            historical.append(species_line(x, own[:, -1, :], species))
            final.append(species_line(x, own[:, :, -1], species))
        rows[0].append(
            Panel(
                f'{each.condition.name}: historical',
                'Generation of opponents',
                'Fitness of last agents',
                historical,
                ylim=(0, 1),
            )
        )
        rows[1].append(
            Panel(
                f'{each.condition.name}: global',
                'Generation of agents',
                'Fitness vs last opponents',
                final,
                ylim=(0, 1),
            )
        )
    return Chart(
        name,
        f'Historical and global progress, {arena}',
        'First: the last generation against opponents of every generation; historical progress '
        'is a curve that falls to the right. Second: every generation against the last opponents; '
        'global '
        f'progress is a curve that rises to the right. {INTERVAL}',
        compact(rows),
        height=1.9,
    )


def _cross(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    panels = []
    groups = [other.condition.name for other in members]
    for each in members:
        marks = []
        for species in SPECIES:
            values = np.stack(
                [paper_cross_values(each, other, species, study) for other in members]
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
        panels.append(
            Panel(
                f'{each.condition.name} agents',
                'Opponents evolved in',
                'Fitness',
                marks,
                ylim=(0, 1),
            )
        )
    return Chart(
        name,
        f'Cross-experiment test, {arena}',
        'The last generation of each condition against the last of every condition (Fig. 4), a '
        "run's "
        'own opponents included as in the paper; the table of tests leaves them out as well. An '
        'agent that does better against the opponents of another condition than against those of '
        'its own '
        f'outperforms that condition. {INTERVAL}',
        in_rows(panels),
    )


def _obstacle(study: Study) -> Iterator[Chart]:
    """Fig. 9: each algorithm's normalised curves with and without the obstacle."""
    pairs = {}
    for each in study.conditions:
        c = each.condition
        pairs.setdefault((c.motor_map, c.algorithm, c.optimizer), {})[c.environment] = each
    by_map: dict[str, list] = {}
    for (motor_map, *_), both in pairs.items():
        if len(both) == 2:
            by_map.setdefault(motor_map, []).append(both)
    for motor_map, found in by_map.items():
        for panel, xlabel, ylabel, axis in (
            ('historical', 'Generation of opponents', 'Normalised fitness, last agents', 0),
            ('global', 'Generation of agents', 'Normalised fitness vs last', 1),
        ):
            rows = []
            for species in SPECIES:
                row = []
                for both in found:
                    marks = [
                        _normalised_line(both[environment], species, axis, study, environment)
                        for environment in ('open', 'obstacle')
                    ]
                    title = f'{both["open"].condition.name}: {PLURAL[species]}'
                    row.append(Panel(title, xlabel, ylabel, marks, ylim=(-0.05, 1.05)))
                rows.append(row)
            yield Chart(
                f'obstacle_comparison_{panel}'
                + ('' if motor_map == 'printed' else f'_{motor_map}'),
                f'{panel.capitalize()} progress with and without the obstacle',
                'Curves of mean performance scaled to [0, 1] each by its own extent (Fig. 9): '
                'the shape can be compared, the height cannot.',
                rows,
                height=1.9,
            )


def _normalised_line(each: Replications, species: str, axis: int, study: Study, environment: str):
    own = performance(each.tournament, species).mean(axis=0)
    curve = own[:, -1] if axis == 1 else own[-1, :]
    dashed = environment == 'obstacle'
    return Line(
        study.generations,
        measures.normalised(curve),
        'With obstacle' if dashed else 'Open arena',
        '#e69f00' if dashed else '#333333',
        dashed=dashed,
        marker='square' if dashed else 'circle',
    )

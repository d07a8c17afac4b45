"""What scripts/comparison does; see there."""

import os
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from marked_pages import MarkedPage, make_parser, markdown, probability

from coevo_manager.analysis.figures import draw
from coevo_manager.analysis.figures.charts import (
    CONDITION_COLOURS,
    CONDITION_MARKERS,
    Bars,
    Chart,
    Line,
    Panel,
)
from coevo_manager.analysis.measures import beyond, games, statistics
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.measures.progress import global_gain
from coevo_manager.analysis.report.tables import write
from coevo_manager.analysis.runs import read_run
from coevo_manager.core.episodes import evaluate_matrix
from coevo_manager.core.evolution.sessions import read_sessions
from coevo_manager.core.species import SPECIES

MOMENTS = 11
"""Snapshots of a run that are compared, at equal distances of ticks."""

INDIVIDUALS = 10
"""The best of a snapshot that play, so that methods with many individuals have no more."""

REFERENCE = 'standard'
"""The condition that the others are tested against."""

THREADS = len(os.sched_getaffinity(0))


class Run:
    """One run at its moments: the best of both species, and what it cost."""

    def __init__(self, folder):
        self.run = read_run(folder)
        self.condition = self.run.named or self.run.condition.name
        phases = self.run.columns('phases')
        generations = np.asarray(phases['generation'], int)
        ticks = np.asarray(phases['ticks'], float)
        kept = np.array(sorted(self.run.snapshots))
        reached = np.interp(kept, generations, ticks)
        wanted = np.linspace(0, reached[-1], MOMENTS)
        self.moments = kept[[int(abs(reached - moment).argmin()) for moment in wanted]]
        found = [self.run.snapshot(int(generation)) for generation in self.moments]
        self.best = {s: [each.best(s, INDIVIDUALS) for each in found] for s in SPECIES}
        self.cost = {
            'generations': int(generations[-1]),
            'episodes': int(np.asarray(phases['episodes'])[-1]),
            'ticks': int(ticks[-1]),
            'seconds': sum(each['seconds'] or 0 for each in read_sessions(Path(folder))),
        }

    def tournament(self):
        """Return mean predator fitness between all moments, (moments, moments)."""
        return mean_fitness(self.best['predator'], self.best['prey'], self.run.environment)

    def measures(self):
        """Return what the tournament of the run says."""
        tournament = self.tournament()
        row = {'exploitability': games.exploitability(tournament)[-1]}
        row['cyclic_share'] = beyond.hodge(tournament[1:, 1:])[2]
        curves = {}
        for species in SPECIES:
            own = performance(tournament[np.newaxis], species)
            late, early = global_gain(own[:, :, 1:].mean(axis=2))
            row[f'{species}_global'] = float((late - early)[0])
            row[f'{species}_retrogression'] = float(
                beyond.retrogression(tournament[np.newaxis], species)[0][0]
            )
            curves[species] = own[0, :, 1:].mean(axis=1)
        return row, curves


def mean_fitness(predators, prey, environment):
    """Return the mean predator fitness between lists of groups, row = predators."""
    fitness = (
        1
        - evaluate_matrix(np.concatenate(predators), np.concatenate(prey), environment, THREADS)
        / environment.episode_ticks
    )
    rows = np.cumsum([0, *map(len, predators)])[:-1]
    columns = np.cumsum([0, *map(len, prey)])[:-1]
    sums = np.add.reduceat(np.add.reduceat(fitness, rows, axis=0), columns, axis=1)
    return sums / np.outer([len(each) for each in predators], [len(each) for each in prey])


def cross_scores(runs):
    """Return each run's mean fitness, both species, against the last of all other conditions."""
    last = {species: [run.best[species][-1] for run in runs] for species in SPECIES}
    fitness = mean_fitness(last['predator'], last['prey'], runs[0].run.environment)
    names = np.array([run.condition for run in runs])
    scores = []
    for place, run in enumerate(runs):
        others = names != run.condition
        scores.append(((fitness[place, others]).mean(), (1 - fitness[others, place]).mean()))
    return np.array(scores)


def collect(runs):
    """Return a row for each run, and the curves of each."""
    rows, curves = [], []
    scores = cross_scores(runs)
    for run, (predators, prey) in zip(runs, scores, strict=True):
        found, curve = run.measures()
        curves.append(curve)
        rows.append(
            {
                'condition': run.condition,
                'seed': run.run.seed,
                'cross_predator': predators,
                'cross_prey': prey,
                'cross': (predators + prey) / 2,
                **found,
                **run.cost,
            }
        )
    return pd.DataFrame(rows), curves


def tests(table):
    """Return Welch tests of the cross-test against the reference, Holm-corrected."""
    rows = []
    if REFERENCE not in set(table.condition):
        return pd.DataFrame(rows)
    theirs = table[table.condition == REFERENCE].cross.to_numpy()
    for name, part in table.groupby('condition', sort=False):
        if name != REFERENCE and min(len(part), len(theirs)) > 1:
            ours = part.cross.to_numpy()
            higher = statistics.compare_groups(ours, theirs)['p_welch']
            two_tailed = 2 * min(higher, 1 - higher)
            rows.append(
                {'condition': name, 'difference': ours.mean() - theirs.mean(), 'p': two_tailed}
            )
    found = pd.DataFrame(rows)
    if len(found):
        found['p_holm'] = statistics.holm(found['p'])
    return found


def spread(values):
    """Return a mean with its standard deviation over runs."""
    deviation = f' ± {values.std(ddof=1):.3f}' if len(values) > 1 else ''
    return f'{values.mean():.3f}{deviation}'


def page_text(table, found):
    """Return the tables of the page in Markdown."""
    header = [
        'condition', 'runs', 'cross-test', 'global progress, predators; prey',
        'retrogression, predators; prey', 'cyclic share', 'exploitability', 'episodes', 'minutes',
    ]  # fmt: skip
    lines = []
    order = table.groupby('condition').cross.mean().sort_values(ascending=False).index
    for name in order:
        part = table[table.condition == name]
        both = [
            '; '.join(spread(part[f'{species}_{measure}']) for species in SPECIES)
            for measure in ('global', 'retrogression')
        ]
        lines.append(
            [
                name, str(len(part)), spread(part.cross), *both, spread(part.cyclic_share),
                spread(part.exploitability), f'{part.episodes.mean():,.0f}',
                f'{part.seconds.mean() / 60:.1f}',
            ]
        )  # fmt: skip
    text = markdown(header, lines)
    if len(found):
        text += '\n' + markdown(
            [f'against {REFERENCE}', 'difference in the cross-test', 'p, Holm'],
            [
                [row.condition, f'{row.difference:+.3f}', probability(row.p_holm)]
                for row in found.itertuples()
            ],
        )
    return text


def charts(table, curves):
    """Return the two figures: who does best against all others, and how they got there."""
    names = list(table.groupby('condition').cross.mean().sort_values(ascending=False).index)
    bars = []
    for species, colour in zip(SPECIES, CONDITION_COLOURS[1:3], strict=True):
        values = [table[table.condition == name][f'cross_{species}'] for name in names]
        means = np.array([each.mean() for each in values])
        errors = np.array([each.std(ddof=1) if len(each) > 1 else 0.0 for each in values])
        bars.append(Bars(names, means, species, colour, low=means - errors, high=means + errors))
    shares = np.linspace(0, 1, MOMENTS)
    rows = []
    for species in SPECIES:
        lines = []
        for place, name in enumerate(names):
            again, colour = divmod(place, len(CONDITION_COLOURS))
            own = [c[species] for c, n in zip(curves, table.condition, strict=True) if n == name]
            lines.append(
                Line(
                    shares,
                    np.mean(own, axis=0),
                    name,
                    CONDITION_COLOURS[colour],
                    dashed=again == 1,
                    marker=CONDITION_MARKERS[(colour + again) % len(CONDITION_MARKERS)],
                )
            )
        rows.append(
            Panel(species.capitalize(), 'Share of the ticks', 'Fitness against all moments', lines)
        )
    last = Panel('', '', 'Fitness', bars)
    return [
        Chart('comparison_cross', 'Last generations against all other methods', '', [[last]]),
        Chart('comparison_progress', "Against the opponents of a run's own moments", '', [rows]),
    ]


def main():
    """Read the runs and write the page."""
    parser = make_parser('comparison')
    options = parser.parse_args()
    try:
        page = MarkedPage(options.page, 'comparison')
        runs = [Run(folder) for folder in options.runs]
    except ValueError as error:
        parser.exit(2, f'comparison: {error}\n')
    if len({run.run.environment for run in runs}) > 1:
        parser.exit(2, 'comparison: the runs are of different worlds, expected one\n')
    table, curves = collect(runs)
    write(table, options.page.with_suffix('.csv'))
    draw.draw_all(charts(table, curves), options.page.parent, lambda amount: None)
    text = page_text(table, tests(table))
    page.fill(text)


if __name__ == '__main__':
    sys.exit(main())

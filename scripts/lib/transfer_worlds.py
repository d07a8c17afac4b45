"""What scripts/transfer does; see there."""

import os

from marked_pages import MarkedPage, make_parser, markdown

from coevo_manager.analysis.figures.draw import save
from coevo_manager.analysis.runs import read_runs
from coevo_manager.analysis.transfer.measure import (
    KERNEL,
    measure_transfer,
    perturbed_alone,
    targets,
)
from coevo_manager.analysis.transfer.report import draw_transfer
from coevo_manager.core.species import SPECIES

CHAMPIONS, DRAWS = 10, 5
WORDS = {'predator': 'predators', 'prey': 'prey'}


def by_condition(table, runs):
    """Return `measure_transfer`'s table with conditions for runs: means and standard deviations.

    `low` and `high` of a change are a standard deviation from its mean.
    """
    names = {run.name: run.condition.name for run in runs}
    grouped = table.assign(run=table.run.map(names)).groupby(
        ['run', 'condition', 'perturbed', 'species'], sort=False
    )
    means = grouped[['fitness', 'change', 'rank_correlation']].mean()
    spread = grouped[['fitness', 'change']].std()
    return means.assign(
        low=means.change - spread.change,
        high=means.change + spread.change,
        spread=spread.fitness,
    ).reset_index()


def changes(table):
    """Return the table of changes when a species alone is perturbed, in pymunk both."""
    worlds = list(table.run.unique())
    own = perturbed_alone(table).set_index(['condition', 'species', 'run'])
    header = ['condition', *(f'{WORDS[s]}: {world}' for s in SPECIES for world in worlds)]
    rows = []
    for condition in dict.fromkeys(target.name for target in targets()):
        if condition == KERNEL:
            continue
        alone = [own.loc[(condition, species, world)] for species in SPECIES for world in worlds]
        cells = [f'{row.change:+.3f} ± {row.high - row.change:.3f}' for row in alone]
        rows.append([condition, *cells])
    return markdown(header, rows)


def fitness(table):
    """Return the table of fitness against the champions of all runs, both species perturbed."""
    conditions = [KERNEL, 'pymunk', 'all perturbations', 'pymunk, all perturbations']
    both = table[table.perturbed == 'both'].set_index(['condition', 'species', 'run'])
    rows = []
    for species in SPECIES:
        for world in table.run.unique():
            own = [both.loc[(condition, species, world)] for condition in conditions]
            cells = [f'{row.fitness:.3f} ± {row.spread:.3f}' for row in own]
            rows.append([f'{WORDS[species]}: {world}', *cells])
    return markdown(['', *conditions], rows)


def main():
    """Measure, and write the page and its figure."""
    parser = make_parser('transfer')
    options = parser.parse_args()
    try:
        page = MarkedPage(options.page, 'transfer')
        runs = read_runs(options.runs)
        table = measure_transfer(runs, CHAMPIONS, DRAWS, len(os.sched_getaffinity(0)))
    except ValueError as error:
        parser.exit(2, f'transfer: {error}\n')
    table = by_condition(table, runs)
    page.fill(f'{changes(table)}\n{fitness(table)}')
    _, vectors = save(draw_transfer(table), options.page.with_suffix(''))
    vectors.unlink()


if __name__ == '__main__':
    main()

"""What scripts/transfer does; see there."""

import argparse
import os
from pathlib import Path

from marked_pages import MarkedPage, markdown

from coevo_manager.analysis.figures.draw import save
from coevo_manager.analysis.runs import read_runs
from coevo_manager.analysis.transfer.measure import KERNEL, measure_transfer, targets
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
    header = ['condition', *(f'{WORDS[s]}: {world}' for s in SPECIES for world in worlds)]
    rows = []
    for condition in dict.fromkeys(target.name for target in targets()):
        if condition == KERNEL:
            continue
        cells = [condition]
        for species in SPECIES:
            for world in worlds:
                own = _rows(table, world, condition, species)
                alone = own[own.perturbed.isin([species, 'both'])].iloc[0]
                cells.append(f'{alone.change:+.3f} ± {alone.high - alone.change:.3f}')
        rows.append(cells)
    return markdown(header, rows)


def fitness(table):
    """Return the table of fitness against the champions of all runs, both species perturbed."""
    conditions = [KERNEL, 'pymunk', 'all perturbations', 'pymunk, all perturbations']
    rows = []
    for species in SPECIES:
        for world in table.run.unique():
            cells = [f'{WORDS[species]}: {world}']
            for condition in conditions:
                own = _rows(table, world, condition, species)
                both = own[own.perturbed == 'both'].iloc[0]
                cells.append(f'{both.fitness:.3f} ± {both.spread:.3f}')
            rows.append(cells)
    return markdown(['', *conditions], rows)


def _rows(table, world, condition, species):
    return table[
        (table.run == world) & (table.condition == condition) & (table.species == species)
    ]


def main():
    """Measure, and write the page and its figure."""
    parser = argparse.ArgumentParser(prog='transfer', add_help=False)
    parser.add_argument('page', type=Path)
    parser.add_argument('runs', type=Path, nargs='+')
    options = parser.parse_args()
    try:
        page = MarkedPage(options.page, 'transfer')
        runs = read_runs(options.runs)
        table = measure_transfer(runs, CHAMPIONS, DRAWS, os.cpu_count())
    except ValueError as error:
        parser.exit(2, f'transfer: {error}\n')
    table = by_condition(table, runs)
    page.fill(f'{changes(table)}\n{fitness(table)}')
    _, vectors = save(draw_transfer(table), options.page.with_suffix(''))
    vectors.unlink()


if __name__ == '__main__':
    main()

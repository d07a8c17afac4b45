"""What scripts/claims does; see there."""

import argparse
import sys
from pathlib import Path

import pandas as pd
from marked_pages import MarkedPage, markdown, probability

from coevo_manager.analysis.report.tables import write

BOTH = ('predator', 'prey')


class Tables:
    """The CSV files of an analysis, by name, restricted to one condition."""

    def __init__(self, folder, arena, condition):
        self._folder, self._key = folder, (arena, condition)

    def __getitem__(self, name):
        table = pd.read_csv(self._folder / 'tables' / f'{name}.csv')
        arena, condition = self._key
        return table[(table.arena == arena) & (table.condition == condition)]


def describe(tables, early):
    """Return what the analysis says of a condition, by the name of a column."""
    matches = tables['master_tournament'].groupby(['predator_generation', 'prey_generation'])
    means = matches.predator_fitness.mean()
    generations = sorted(tables['master_tournament'].predator_generation.unique())
    last = generations[-1]
    early = min(generations[1:], key=lambda each: abs(each - early))
    row = {
        'seeds': tables['runs'].seed.nunique(),
        'generations': last,
        'early': early,
        'contemporaries': means[last, last],
        'late_predators_early_prey': means[last, early],
        'early_predators_late_prey': means[early, last],
        'cyclic_share': tables['cyclicity'].groupby('seed').cyclic_share.first().mean(),
    }
    verdicts = tables['verdicts'].set_index(['species', 'measure'])
    durations = tables['durations'].set_index(['species', 'measure']).duration_paper
    behaviour = tables['behaviour']
    behaviour = behaviour[behaviour.opponents == 'fixed'].groupby(['species', 'generation'])
    correlation = tables['complexity_correlation']
    correlation = correlation[correlation.seed == 'mean'].set_index('species').r
    for species in BOTH:
        for measure in ('historical', 'global'):
            found = verdicts.loc[species, measure]
            prefix = f'{species}_{measure}'
            row[prefix] = found.difference
            row[f'{prefix}_low'], row[f'{prefix}_high'] = found.bootstrap_low, found.bootstrap_high
            row[f'{prefix}_g'] = found.hedges_g
            row[f'{prefix}_verdict'] = found.verdict
            row[f'{prefix}_duration'] = durations.get((species, measure))
        for name in ('complexity', 'reversals', 'backward'):
            for when, generation in (('early', early), ('late', last)):
                row[f'{species}_{name}_{when}'] = behaviour[name].mean()[species, generation]
        row[f'{species}_correlation'] = correlation.get(species)
    return row


def progress(row, name):
    """Return a cell that tells of one measure of progress."""
    text = f'{row[name]:+.3f}'
    if pd.notna(row[f'{name}_low']):
        text += f' [{row[f"{name}_low"]:+.3f}, {row[f"{name}_high"]:+.3f}]'
    duration = row[f'{name}_duration']
    text += f' {row[f"{name}_verdict"]}'
    return text if pd.isna(duration) else f'{text}, to {int(duration):,}'


def change(row, name, digits=2):
    """Return a cell that tells of a measure early and late, of predators and prey."""
    cells = (
        f'{row[f"{species}_{name}_early"]:.{digits}f} → {row[f"{species}_{name}_late"]:.{digits}f}'
        for species in BOTH
    )
    return '; '.join(cells)


def correlation(row, species):
    """Return a cell that tells of a correlation; a dash where one side never changed."""
    r = row[f'{species}_correlation']
    return '-' if pd.isna(r) else f'{r:+.2f}'


def conditions_table(table):
    """Return the tables of what each condition shows."""
    fitness, gains, behaviours = [], [], []
    for row in table.to_dict('records'):
        name = [row['arena'], row['condition'], str(row['seeds'])]
        fitness.append(
            [
                *name,
                f'{row["generations"]:,}',
                *(
                    f'{row[column]:.2f}'
                    for column in (
                        'contemporaries',
                        'late_predators_early_prey',
                        'early_predators_late_prey',
                    )
                ),
                f'{row["cyclic_share"]:.1%}',
            ]
        )
        gains.append(
            [
                *name,
                *(progress(row, f'{s}_{m}') for s in BOTH for m in ('historical', 'global')),
            ]
        )
        behaviours.append(
            [
                *name,
                change(row, 'complexity'),
                change(row, 'reversals', 1),
                change(row, 'backward'),
                '; '.join(correlation(row, species) for species in BOTH),
            ]
        )
    start = ['world', 'condition', 'seeds']
    return '\n'.join(
        (
            markdown(
                [
                    *start,
                    'generations',
                    'contemporaries',
                    'last predators, early prey',
                    'early predators, last prey',
                    'cyclic',
                ],
                fitness,
            ),
            markdown(
                [
                    *start,
                    'predators, historical',
                    'predators, global',
                    'prey, historical',
                    'prey, global',
                ],
                gains,
            ),
            markdown(
                [
                    *start,
                    'complexity without noise, predators; prey',
                    'reversals in 100 s',
                    'share of time backward',
                    'r of complexity and performance',
                ],
                behaviours,
            ),
        )
    )


def cross_table(folder):
    """Return the table of conditions against each other; '' where one stands alone."""
    path = folder / 'tables' / 'cross_tests.csv'
    if not path.exists() or not len(tests := pd.read_csv(path)):
        return ''
    rows = []
    for row in tests[tests.opponents == 'all'].itertuples():
        interval = (
            f' [{row.bootstrap_low:+.3f}, {row.bootstrap_high:+.3f}]'
            if pd.notna(row.bootstrap_low)
            else ''
        )
        rows.append(
            [
                *(row.arena, row.species, row.agents, row.against),
                f'{row.difference:+.3f}{interval}',
                probability(row.p_paired_holm),
            ]
        )
    header = [
        'world',
        'species',
        'agents of',
        'against those of',
        'difference in fitness',
        'p, Holm',
    ]
    return '\n' + markdown(header, rows)


def main():
    """Read the analysis and write the page."""
    parser = argparse.ArgumentParser(prog='claims', add_help=False)
    parser.add_argument('results', type=Path)
    parser.add_argument('page', type=Path)
    parser.add_argument('--early', type=int, default=10_000)
    options = parser.parse_args()
    if not (options.results / 'tables' / 'runs.csv').is_file():
        parser.exit(2, f'claims: {options.results} is no folder that analyze wrote\n')
    try:
        page = MarkedPage(options.page, 'claims')
    except ValueError as error:
        parser.exit(2, f'claims: {error}\n')
    runs = pd.read_csv(options.results / 'tables' / 'runs.csv')
    table = pd.DataFrame(
        {'arena': arena, 'condition': condition}
        | describe(Tables(options.results, arena, condition), options.early)
        for arena, condition in runs.groupby(['arena', 'condition'], sort=False).groups
    )
    text = conditions_table(table) + cross_table(options.results)
    write(table, options.page.with_suffix('.csv'))
    page.fill(text)


if __name__ == '__main__':
    sys.exit(main())

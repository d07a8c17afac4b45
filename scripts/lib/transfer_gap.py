"""What scripts/transfer-gap does; see there."""

import argparse
import os
from pathlib import Path

import pandas as pd

from coevo_manager.analysis.figures.draw import save
from coevo_manager.analysis.report.tables import write
from coevo_manager.analysis.runs import read_run
from coevo_manager.analysis.transfer.measure import ALL, measure_transfer
from coevo_manager.analysis.transfer.report import draw_transfer
from coevo_manager.core.evolution import Evolution, load_configuration
from coevo_manager.core.local_evaluator import LocalEvaluator

KINDS = {'perfect': {}, 'imperfect': ALL}
NUMBERS = {
    'population': 40,
    'generations': 50,
    'swap_generations': 250,
    'snapshot_generations': 250,
}
CHAMPIONS, DRAWS = 5, 5


def evolve(folder, seed, phases, perturbations):
    """Evolve a run unless the folder has one."""
    if not (folder / 'report.md').exists():
        configuration = load_configuration(
            {**NUMBERS, 'world': 'faithful', 'phases': phases, 'seed': seed, **perturbations}
        )
        evaluator = LocalEvaluator(configuration.make_environment(), threads=os.cpu_count())
        Evolution(configuration, evaluator, folder).run()
    return read_run(folder)


def summary(table):
    """Return the means over runs of a kind: change when perturbed alone, and fitness."""
    table = table.assign(evolved=table.run.str.rpartition('-')[0])
    columns = {}
    for evolved in KINDS:
        rows = table[table.evolved == evolved]
        for species in ('predator', 'prey'):
            own = rows[rows.species == species]
            alone = own[own.perturbed == species].groupby('condition', sort=False)
            columns[f'{evolved}: change of {species} alone'] = alone.change.mean()
        both = rows[rows.perturbed == 'both']
        for species in ('predator', 'prey'):
            mean = both[both.species == species].groupby('condition', sort=False).fitness.mean()
            columns[f'{evolved}: {species} fitness'] = mean
    return pd.DataFrame(columns).loc[table.condition.unique()]


def main():
    """Evolve, measure, print and write."""
    parser = argparse.ArgumentParser(prog='transfer-gap', add_help=False)
    parser.add_argument('out', type=Path)
    parser.add_argument('--seeds', type=int, default=3)
    parser.add_argument('--phases', type=int, default=60)
    options = parser.parse_args()
    runs = []
    for kind, perturbations in KINDS.items():
        for seed in range(1, options.seeds + 1):
            runs.append(
                evolve(options.out / f'{kind}-{seed}', seed, options.phases, perturbations)
            )
            print(runs[-1].folder, flush=True)
    table = measure_transfer(runs, CHAMPIONS, DRAWS, os.cpu_count())
    write(table, options.out / 'transfer.csv')
    save(draw_transfer(table), options.out / 'transfer')
    means = summary(table)
    print(means.round(3).T.to_string())
    worst = table[(table.condition == 'all perturbations') & (table.perturbed == table.species)]
    print(worst.set_index(['run', 'species'])[['fitness', 'change', 'low', 'high']].round(3))


if __name__ == '__main__':
    main()

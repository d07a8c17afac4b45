"""Evolve a small run in this process, and set its last generation against its first."""

import numpy as np

import red_queen as rq

SETTINGS = {'population': 16, 'phases': 10, 'generations': 20, 'snapshot_generations': 50}


def show(stats):
    """Print where the run stands after each phase."""
    if isinstance(stats, rq.PhaseStats):
        print(f'{stats.progress:4.0%}  predators {stats.predator_fitness:.2f}')


rq.evolve('runs/tournament', observer=show, swap_generations=40, **SETTINGS)
run = rq.read_run('runs/tournament')
first, last = (run.snapshot(generation) for generation in (0, max(run.snapshots)))
for hunters in (first, last):
    row = [
        rq.fitness(
            rq.evaluate_matrix(hunters.predators, hunted.prey, run.environment), 'predator'
        ).mean()
        for hunted in (first, last)
    ]
    print(f'predators of {hunters.generation}: fitness {np.round(row, 2)} against prey of 0, last')

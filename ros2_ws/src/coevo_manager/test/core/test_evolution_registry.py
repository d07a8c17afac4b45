"""Every algorithm and optimizer in a game with a known answer: it improves, and resumes exactly.

The game has no episodes. A genome is as good as it is near to its species' target, and prey
survive the longer the better they are and the worse the predator is.
"""

import collections
import itertools

import numpy as np
import pytest
from evolve_runs import read_files
from lineages import follow

from coevo_manager.core.evaluation import Lineages
from coevo_manager.core.evolution import (
    Evolution,
    PhaseStats,
    algorithms,
    load_configuration,
    optimizers,
)
from coevo_manager.core.species import SPECIES

TARGETS = {'predator': 2.0, 'prey': -1.0}

SMALL = {
    'hidden': 1,
    'population': 8,
    'selected': 4,
    'episode_ticks': 1_000_000,
    'openai_pairs': 5,
    'maxsolve_size': 6,
    'maxsolve_period': 10,
}

CASES = [
    *((algorithm, None) for algorithm in algorithms.names()),
    *(('standard', name) for name in optimizers.names() if name != 'one_plus_one'),
]


def configure(algorithm, optimizer, phases, generations):
    values = {
        **SMALL,
        'algorithm': algorithm,
        'phases': phases,
        'generations': generations,
        'swap_generations': generations,
        'snapshot_generations': 3 * generations,
    }
    if algorithm == 'vanilla':
        values['selected'] = values['population']
    if optimizer:
        values['optimizer'] = optimizer
    return load_configuration(values)


def distance(genomes, species):
    """Mean squared distance of genes from the species' target, (n,)."""
    return np.mean((genomes.astype(float) - TARGETS[species]) ** 2, axis=1)


def survival(predators, prey, environment):
    """Capture ticks of pairs, int32 (n,): half an episode where both are equally good."""
    lead = distance(predators, 'predator') - distance(prey, 'prey')
    return (1 + environment.episode_ticks / (1 + np.exp(-lead / 10))).astype(np.int32)


def meet(species, genome, opponents, environment):
    ours = np.broadcast_to(genome, opponents.shape)
    pairs = (ours, opponents) if species == 'predator' else (opponents, ours)
    return survival(*pairs, environment)


class Game:
    """Answers in turn what the game says; an `Evaluator`."""

    slots = 8
    longest_lineage = 4

    def __init__(self, configuration):
        self.environment = configuration.make_environment()
        self._answers = collections.deque()
        self._tickets = itertools.count()

    def submit(self, work):
        if isinstance(work, Lineages):
            ticks = follow(work, self.environment, meet)[0]
        else:
            predators = work.predators[work.predator_index]
            ticks = survival(predators, work.prey[work.prey_index], self.environment)
        ticket = next(self._tickets)
        self._answers.append((ticket, ticks))
        return ticket

    def collect(self, timeout=None):
        return self._answers.popleft()

    def cancel(self):
        self._answers.clear()


@pytest.mark.parametrize(('algorithm', 'optimizer'), CASES)
def test_a_run_that_was_stopped_goes_on_as_one_that_was_not(tmp_path, algorithm, optimizer):
    configuration = configure(algorithm, optimizer, phases=6, generations=4)

    def stop(stats):
        if isinstance(stats, PhaseStats) and stats.phase == 4:
            evolution.stop()

    evolution = Evolution(configuration, Game(configuration), tmp_path / 'stopped', stop)
    assert not evolution.run().finished
    assert Evolution.resume(tmp_path / 'stopped', Game(configuration)).run().finished
    assert Evolution(configuration, Game(configuration), tmp_path / 'whole').run().finished
    assert read_files(tmp_path / 'stopped') == read_files(tmp_path / 'whole')
    assert 'resumed after phase 4' in (tmp_path / 'stopped' / 'run.log').read_text()


@pytest.mark.parametrize(('algorithm', 'optimizer'), CASES)
def test_both_species_approach_the_known_answer(tmp_path, algorithm, optimizer):
    configuration = configure(algorithm, optimizer, phases=16, generations=25)
    assert Evolution(configuration, Game(configuration), tmp_path / 'run').run().finished
    first, *_, last = sorted((tmp_path / 'run' / 'snapshots').iterdir())
    for species, name in zip(SPECIES, ('predators', 'prey'), strict=True):
        before, after = (distance(np.load(path)[name], species) for path in (first, last))
        assert after.min() < before.min() / 2

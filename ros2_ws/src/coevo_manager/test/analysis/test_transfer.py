"""Transfer of champions: what the numbers mean, the files, bad input."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from coevo_manager.analysis.runs import AnalysisError, read_run
from coevo_manager.analysis.transfer import command as transfer
from coevo_manager.analysis.transfer.measure import (
    ALL,
    KERNEL,
    STANDARD,
    champions,
    hurt,
    measure_transfer,
    targets,
)
from coevo_manager.core.configuration import Configuration
from coevo_manager.core.episodes import evaluate_pairs
from coevo_manager.core.evolution.evolution import Evolution
from coevo_manager.core.local_evaluator import LocalEvaluator
from marxbot_sim.core.perturbations import Perturbations

SMALL = Configuration(
    population=4,
    selected=2,
    phases=2,
    generations=3,
    swap_generations=3,
    snapshot_generations=3,
    episode_ticks=120,
)


def evolve(folder, **changes):
    configuration = dataclasses.replace(SMALL, **changes)
    evaluator = LocalEvaluator(configuration.make_environment())
    Evolution(configuration, evaluator, folder).run()
    return folder


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    root = tmp_path_factory.mktemp('runs')
    evolve(root / 'perfect')
    evolve(root / 'imperfect', camera_noise=0.05, latency_ticks=1, seed=2)
    return [read_run(root / 'perfect'), read_run(root / 'imperfect')]


@pytest.fixture(scope='module')
def table(runs):
    return measure_transfer(runs, 2, 2, 1)


def select(table, **values):
    for column, value in values.items():
        table = table[table[column] == value]
    return table


def test_every_condition_has_a_row_for_each_run_and_species(table):
    assert len(table) == 2 * 2 * len(targets())
    names = {KERNEL, 'pymunk', 'all perturbations', 'pymunk, all perturbations', *STANDARD}
    assert set(table.condition) == names
    assert (table.low <= table.change + 1e-12).all()
    assert (table.high >= table.change - 1e-12).all()
    assert Perturbations(**ALL).active


def test_the_kernel_is_the_reference(table):
    kernel = select(table, condition=KERNEL)
    assert (kernel.change == 0).all()
    for _, rows in table.groupby(['run', 'species']):
        reference = select(rows, condition=KERNEL).fitness.iloc[0]
        np.testing.assert_allclose(rows.fitness - rows.change, reference)


def test_what_the_species_gain_and_lose_sums_to_one(table):
    for _, rows in table.groupby(['condition', 'perturbed']):
        means = rows.groupby('species').fitness.mean()
        assert means.sum() == pytest.approx(1)


def test_a_fitness_is_that_of_the_episodes(runs, table):
    """Predators of the first run, alone with noisy sensors, recomputed pair by pair."""
    predators = champions(runs[0], 2)[0]
    prey = np.concatenate([champions(run, 2)[1] for run in runs])
    i, j = np.indices((2, 4)).reshape(2, -1)
    fitness = []
    for seed in (1, 2):
        noisy = Perturbations(**STANDARD['sensor noise'], robots='predator', seed=seed)
        environment = dataclasses.replace(runs[0].environment, perturbations=noisy)
        fitness.append(1 - evaluate_pairs(predators, prey, i, j, environment) / 120)
    row = select(
        table, run='perfect', condition='sensor noise', perturbed='predator', species='predator'
    )
    assert row.fitness.item() == pytest.approx(np.mean(fitness))


def test_champions_are_the_fittest_of_the_last_snapshot(runs):
    snapshot = runs[0].snapshot(max(runs[0].snapshots))
    predators, prey = champions(runs[0], 1)
    np.testing.assert_array_equal(
        predators[0], snapshot.predators[snapshot.fitness.mean(axis=1).argmax()]
    )
    np.testing.assert_array_equal(prey[0], snapshot.prey[snapshot.fitness.mean(axis=0).argmin()])


def test_who_is_hurt():
    rows = [
        ('noise', 'predator', 'predator', -0.2, -0.1),
        ('noise', 'predator', 'prey', -0.9, -0.8),
        ('noise', 'prey', 'prey', -0.1, 0.1),
        ('noise', 'both', 'prey', -0.9, -0.8),
        ('pymunk', 'both', 'predator', -0.2, -0.1),
        ('pymunk', 'both', 'prey', -0.2, -0.1),
        ('latency', 'predator', 'predator', 0.0, 0.0),
    ]
    table = pd.DataFrame(rows, columns=['condition', 'perturbed', 'species', 'low', 'high'])
    result = hurt(table.assign(run='run'))
    assert result.to_dict() == {
        ('run', 'noise'): 'predator',
        ('run', 'pymunk'): 'predator and prey',
    }


def test_the_command_writes_the_same_files_whatever_the_threads(runs, tmp_path, capsys):
    for threads in ('1', '2'):
        arguments = [str(runs[0].folder), '--out', str(tmp_path / threads)]
        options = ['--champions', '2', '--draws', '1', '--threads', threads]
        assert transfer.main(arguments + options) == 0
    assert capsys.readouterr().out.split()[-1] == str(tmp_path / '2' / 'transfer.md')
    for name in ('transfer.csv', 'transfer.md', 'transfer.png', 'transfer.svg'):
        content = (tmp_path / '1' / name).read_bytes()
        assert content == (tmp_path / '2' / name).read_bytes()
        assert len(content) > 1000
    assert sorted(path.suffix for path in (tmp_path / '1').iterdir()) == [
        '.csv', '.md', '.png', '.svg',
    ]  # fmt: skip
    lines = (tmp_path / '1' / 'transfer.md').read_text().splitlines()
    table = [line for line in lines if line.startswith('| ')]
    assert len(table) == 1 + len({condition.name for condition in targets()})
    assert len({line.count('|') for line in table}) == 1


def test_bad_input_is_one_sentence_and_leaves_nothing(runs, tmp_path, capsys):
    out = tmp_path / 'out'
    for arguments, expected in (
        ([str(tmp_path)], 'holds no run'),
        ([str(runs[0].folder), '--champions', '5'], 'champions is 5, expected at most 4'),
    ):
        assert transfer.main([*arguments, '--out', str(out)]) == 2
        error = capsys.readouterr().err
        assert expected in error
        assert len(error.strip().splitlines()) == 1
        assert not out.exists() or not list(out.iterdir())
    with pytest.raises(SystemExit) as end:
        transfer.main([str(runs[0].folder), '--out', str(out), '--draws', '0'])
    assert end.value.code == 2
    assert 'whole number' in capsys.readouterr().err


def test_runs_of_different_arenas_are_refused(runs, tmp_path):
    other = read_run(evolve(tmp_path / 'obstacle', environment='obstacle'))
    with pytest.raises(AnalysisError, match='differ in arena'):
        measure_transfer([runs[0], other], 1, 1, 1)

"""Choosing genomes from runs, and those that are shipped."""

import json

import numpy as np
import pytest

from neuro_controller.core.champions import SHIPPED, select_champion
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.origin import read_origin
from neuro_controller.core.settings import FIRST_RUNS
from neuro_controller.core.snapshot import read_snapshot, snapshots

CONFIGURATION = {
    'environment': 'obstacle',
    'motor_map': 'signed',
    'predator_speed': None,
    'prey_speed': 6,
    'episode_ticks': 500,
}
RECORD = {'version': 1, 'configuration': CONFIGURATION, 'versions': {'commit': 'abc123'}}


def write_snapshot(path, seed, fitness, generation=0, **arrays):
    rng = np.random.default_rng(seed)
    predators, prey = random_genomes(len(fitness), rng), random_genomes(len(fitness[0]), rng)
    path.parent.mkdir(parents=True, exist_ok=True)
    fitness = np.array(fitness, np.float32)
    arrays |= {'predators': predators, 'prey': prey, 'fitness': fitness, 'generation': generation}
    np.savez(path, **arrays)
    return predators, prey


@pytest.fixture
def run(tmp_path):
    """Two snapshots; predator 1 is the best, and prey 2, against which predators earn least."""
    write_snapshot(tmp_path / 'snapshots' / 'gen_000500.npz', 1, [[0.5]], 500)
    fitness = [[0.1, 0.2, 0.0], [0.9, 0.8, 0.3], [0.5, 0.5, 0.1]]
    genomes = write_snapshot(tmp_path / 'snapshots' / 'gen_010000.npz', 2, fitness, 10_000)
    (tmp_path / 'run.json').write_text(json.dumps(RECORD))
    return tmp_path, *genomes


def test_the_best_come_first_in_both_species(run):
    folder, predators, prey = run
    snapshot = read_snapshot(folder / 'snapshots' / 'gen_010000.npz')
    assert (snapshot.best('predator', 3) == predators[[1, 2, 0]]).all()
    assert (snapshot.best('prey', 3) == prey[[2, 0, 1]]).all()
    assert (snapshot.population('prey') == prey).all()


def test_means_that_float32_cannot_tell_apart_are_ranked(tmp_path):
    """The second predator is better by the last bit of one cell: 1e-7 of 1000 opponents' mean."""
    fitness = np.full((2, 1000), 0.7, np.float32)
    fitness[1, 0] = np.nextafter(np.float32(0.7), np.float32(1))
    assert fitness.mean(axis=1)[0] == fitness.mean(axis=1)[1]
    path = tmp_path / 'one.npz'
    predators, _ = write_snapshot(path, 3, fitness, run=json.dumps(RECORD))
    assert list(read_snapshot(path).ranking('predator')) == [1, 0]
    assert (select_champion(str(path), 'predator').genome == predators[1]).all()


def test_a_genome_is_named_by_run_generation_and_rank(run):
    folder, predators, prey = run
    assert (select_champion(str(folder), 'predator').genome == predators[1]).all()
    assert (select_champion(f'{folder}:10000:1', 'prey').genome == prey[0]).all()
    first = np.load(folder / 'snapshots' / 'gen_000500.npz')
    assert (select_champion(f'{folder}:500', 'prey').genome == first['prey'][0]).all()
    path = folder / 'snapshots' / 'gen_010000.npz'
    assert (select_champion(f'{path}:0:2', 'predator').genome == predators[0]).all()
    assert list(snapshots(folder)) == [500, 10000]


def test_a_champion_knows_the_robot_it_evolved_in(run):
    champion = select_champion(f'{run[0]}:10000', 'predator')
    assert champion.settings == {
        'max_wheel_speed': 10.0,  # the paper's, with the obstacle
        'motor_map': 'signed',
        'episode_ticks': 500,
        # the run is older than the choice of these
        'infrared_response': 'linear',
        'ground_coding': 'raw',
    }
    assert select_champion(f'{run[0]}:10000', 'prey').settings['max_wheel_speed'] == 6.0
    name = run[0].name
    assert str(champion) == f'predator of rank 0 in generation 10000 of run {name}, commit abc123'


def test_a_snapshot_alone_tells_of_its_run(tmp_path):
    path = tmp_path / 'lone.npz'
    write_snapshot(path, 1, [[0.5]], 7, run=json.dumps({**RECORD, 'run': 'first'}))
    origin = read_origin(path)
    assert (origin.run, origin.generation) == ('first', 7)
    assert origin.configuration == {**FIRST_RUNS, **CONFIGURATION}


@pytest.mark.parametrize(
    ('record', 'sentence'),
    [
        (None, 'run.json does not exist'),
        ('{}', "the record of its run lacks 'configuration'"),
        ('not JSON', 'the record of its run makes no sense'),
        ('[' * 100_000, 'the record of its run makes no sense'),
        ('{"configuration": 3}', 'the record of its run makes no sense'),
        ('{"configuration": {"prey_speed": 6}}', "lacks 'predator_speed'"),
        (json.dumps({'configuration': {**CONFIGURATION, 'prey_speed': 'x'}}), 'makes no sense'),
        (json.dumps({'configuration': {**CONFIGURATION, 'motor_map': []}}), 'makes no sense'),
    ],
)
def test_a_genome_without_its_run_is_refused_in_a_sentence(tmp_path, record, sentence):
    path = tmp_path / 'lone.npz'
    write_snapshot(path, 1, [[0.5]], **({} if record is None else {'run': record}))
    with pytest.raises(ValueError, match=r'^[^\n]*$') as error:
        select_champion(str(path), 'prey')
    assert f'{path} is damaged: ' in str(error.value)
    assert sentence in str(error.value)


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('{}:7', 'has no snapshot of generation 7, only of 500, 10000'),
        ('{}:500:3', 'prey rank is 3, expected 0 to 0'),
        ('{}:x', 'expected RUN, RUN:GENERATION or RUN:GENERATION:RANK'),
        ('{}/nowhere', 'does not exist'),
        ('{}/snapshots', 'holds no snapshots'),
        ('{}/bad.npz', 'is damaged'),
        ('{}/other.npz', 'is damaged'),
        ('shipped/nothing', 'does not exist'),
    ],
)
def test_what_names_no_genome_is_refused_in_a_sentence(run, text, sentence):
    folder = run[0]
    (folder / 'bad.npz').write_bytes(b'PK not really')
    np.savez(folder / 'other.npz', predators=np.zeros((2, 442)), prey=np.zeros((2, 442)))
    with pytest.raises(ValueError, match=r'^[^\n]*$') as error:
        select_champion(text.format(folder), 'prey')
    assert sentence in str(error.value)


@pytest.mark.parametrize('name', ['open', 'obstacle'])
def test_shipped_champions_are_snapshots(name):
    snapshot = read_snapshot(SHIPPED / f'{name}.npz')
    assert read_origin(SHIPPED / f'{name}.npz').generation >= 15_000
    assert len(snapshot.predators) and len(snapshot.prey)
    assert (SHIPPED / f'{name}.npz').stat().st_size < 100_000

"""Choosing genomes from runs, and those that are shipped."""

import numpy as np
import pytest

from neuro_controller.core.champions import SHIPPED, select_genome
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.snapshot import read_snapshot, snapshots


def write_snapshot(path, seed, fitness):
    rng = np.random.default_rng(seed)
    predators, prey = random_genomes(len(fitness), rng), random_genomes(len(fitness[0]), rng)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, predators=predators, prey=prey, fitness=np.array(fitness, np.float32))
    return predators, prey


@pytest.fixture
def run(tmp_path):
    """Two snapshots; predator 1 is the best, and prey 2, against which predators earn least."""
    write_snapshot(tmp_path / 'snapshots' / 'gen_000500.npz', 1, [[0.5]])
    fitness = [[0.1, 0.2, 0.0], [0.9, 0.8, 0.3], [0.5, 0.5, 0.1]]
    genomes = write_snapshot(tmp_path / 'snapshots' / 'gen_010000.npz', 2, fitness)
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
    predators, _ = write_snapshot(tmp_path / 'one.npz', 3, fitness)
    assert list(read_snapshot(tmp_path / 'one.npz').ranking('predator')) == [1, 0]
    assert (select_genome(str(tmp_path / 'one.npz'), 'predator') == predators[1]).all()


def test_a_genome_is_named_by_run_generation_and_rank(run):
    folder, predators, prey = run
    assert (select_genome(str(folder), 'predator') == predators[1]).all()
    assert (select_genome(f'{folder}:10000:1', 'prey') == prey[0]).all()
    first = np.load(folder / 'snapshots' / 'gen_000500.npz')
    assert (select_genome(f'{folder}:500', 'prey') == first['prey'][0]).all()
    path = folder / 'snapshots' / 'gen_010000.npz'
    assert (select_genome(f'{path}:0:2', 'predator') == predators[0]).all()
    assert list(snapshots(folder)) == [500, 10000]


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('{}:7', 'has no snapshot of generation 7, only of 500, 10000'),
        ('{}:500:3', 'prey rank is 3, expected 0 to 0'),
        ('{}:x', 'expected RUN, RUN:GENERATION or RUN:GENERATION:RANK'),
        ('{}/nowhere', 'does not exist'),
        ('{}/snapshots', 'holds no snapshots'),
        ('{}/bad.npz', 'is not a snapshot'),
        ('{}/other.npz', 'is not a snapshot'),
        ('shipped/nothing', 'does not exist'),
    ],
)
def test_what_names_no_genome_is_refused_in_a_sentence(run, text, sentence):
    folder = run[0]
    (folder / 'bad.npz').write_bytes(b'PK not really')
    np.savez(folder / 'other.npz', predators=np.zeros((2, 442)), prey=np.zeros((2, 442)))
    with pytest.raises(ValueError, match=r'^[^\n]*$') as error:
        select_genome(text.format(folder), 'prey')
    assert sentence in str(error.value)


@pytest.mark.parametrize('name', ['open', 'obstacle', 'open_signed'])
def test_shipped_champions_are_snapshots(name):
    snapshot = read_snapshot(SHIPPED / f'{name}.npz')
    assert len(snapshot.predators) and len(snapshot.prey)
    assert (SHIPPED / f'{name}.npz').stat().st_size < 100_000

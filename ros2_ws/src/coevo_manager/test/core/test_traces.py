"""Episodes recorded eight at a time are those that `World` and `Controller` play."""

import dataclasses

import numpy as np
import pytest

from coevo_manager.core.behaviour import complexity
from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes import measure_pairs, trace_pair, trace_pairs
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.champions import SHIPPED
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.snapshot import read_snapshot

NOISY = Perturbations(
    camera_noise=0.05, motor_noise=0.1, latency_ticks=1, start_displacement=0.3, start_rotation=3.0
)
WORLDS = {
    'perfect': Environment(episode_ticks=120, motor_map='signed'),
    'noisy, obstacle': Environment(episode_ticks=120, obstacle=True, perturbations=NOISY),
    'pymunk': Environment(episode_ticks=40, physics='pymunk'),
}


@pytest.fixture(scope='module')
def genomes():
    rng = np.random.default_rng(1)
    champions = read_snapshot(SHIPPED / 'open.npz')
    return [
        np.concatenate([champions.population(species), random_genomes(5, rng)])
        for species in ('predator', 'prey')
    ]


@pytest.mark.parametrize('world', WORLDS)
def test_both_routes_record_the_same_bits(genomes, world):
    predators, prey = genomes
    i, j = np.arange(10), np.arange(10)[::-1]
    traces = list(trace_pairs(predators, prey, i, j, WORLDS[world]))
    assert len(traces) == 10
    for k, trace in enumerate(traces):
        alone = trace_pair(predators[i[k]], prey[j[k]], WORLDS[world])
        for field in dataclasses.fields(alone):
            expected, found = getattr(alone, field.name), getattr(trace, field.name)
            assert np.array_equal(found, expected), (k, field.name)


def test_they_are_the_episodes_of_the_batch(genomes):
    predators, prey = genomes
    index = np.arange(10)
    world = WORLDS['noisy, obstacle']
    ticks, expected = measure_pairs(predators, prey, index, index, world)
    for k, trace in enumerate(trace_pairs(predators, prey, index, index, world)):
        assert trace.ticks == ticks[k]
        assert complexity(trace.wheels) == pytest.approx(expected[k], rel=1e-4)

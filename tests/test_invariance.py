"""What an episode's result must not depend on."""

import numpy as np
import pytest

from coevo_manager.core.episodes import (
    Environment,
    EpisodeStream,
    evaluate_matrix,
    evaluate_pairs,
    measure_pairs,
    trace_pair,
)
from marxbot_sim.core.world import World
from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import random_genomes

CONDITIONS = [
    Environment(),
    Environment(obstacle=True, motor_map='printed'),
    Environment(wall_contact='slide', wall_friction=0.0, infrared_response='linear'),
    Environment(
        obstacle=True,
        wall_contact='undo',
        ground_coding='raw',
        prey_speed=7.5,
        episode_ticks=300,
    ),
]


def populations(n, seed=0):
    rng = np.random.default_rng(seed)
    return random_genomes(n, rng), random_genomes(n, rng)


@pytest.fixture(scope='module', params=CONDITIONS, ids=range(len(CONDITIONS)))
def results(request):
    """An environment and the episodes of 12 x 12 genomes in it."""
    predators, prey = populations(12)
    i, j = np.indices((12, 12)).reshape(2, -1)
    ticks, complexity = measure_pairs(predators, prey, i, j, request.param)
    return request.param, predators, prey, i, j, ticks, complexity


def test_neither_order_nor_company_nor_threads_matter(results):
    environment, predators, prey, i, j, ticks, complexity = results
    assert len(np.unique(ticks)) > 5
    rng = np.random.default_rng(1)
    for size, threads in ((144, 1), (144, 2), (37, 1), (5, 2), (1, 1)):
        order = rng.permutation(144)[:size]
        again = measure_pairs(predators, prey, i[order], j[order], environment, threads)
        assert (again[0] == ticks[order]).all()
        assert (again[1] == complexity[order]).all()
    assert (evaluate_pairs(predators, prey, i, j, environment) == ticks).all()
    matrix = evaluate_matrix(predators, prey, environment, threads=2)
    assert (matrix.ravel() == ticks).all()


def test_neither_copies_of_genomes_nor_thread_chunks_matter(results):
    environment, predators, prey, i, j, ticks, _ = results
    # 1440 episodes: several chunks for each thread, genomes of their own for each episode
    many = np.tile(np.arange(144), 10)
    for threads in (1, 3):
        again = evaluate_pairs(predators, prey, i[many], j[many], environment, threads)
        assert (again == ticks[many]).all()
    pairs = np.arange(144)
    again = evaluate_pairs(predators[i], prey[j], pairs, pairs, environment, 2)
    assert (again == ticks).all()


@pytest.mark.parametrize('seed', range(5))
def test_a_stream_equals_the_batch_however_requests_interleave(results, seed):
    environment, predators, prey, i, j, ticks, complexity = results
    rng = np.random.default_rng(seed)
    rest = list(np.split(rng.permutation(144), np.sort(rng.integers(1, 144, 12))))
    expected, seen = {}, {}
    stream = EpisodeStream(environment, measure=True)
    while rest or stream.pending:
        while rest and (not stream.pending or rng.random() < 0.4):
            part = rest.pop()
            ticket = f'request {len(rest)}'
            expected[ticket] = part
            stream.submit(ticket, predators, prey, i[part], j[part])
        for ticket, part_ticks, part_complexity in stream.advance():
            assert ticket not in seen
            seen[ticket] = part_ticks
            assert (part_ticks == ticks[expected[ticket]]).all()
            assert (part_complexity == complexity[expected[ticket]]).all()
    assert seen.keys() == expected.keys()
    assert stream.advance() == []


def driven(predator, prey, environment):
    """An episode stepped in Python through World and Controller, as the nodes do it."""
    world = World(environment.arena)
    world.reset()
    controllers = [
        Controller(genome, speed, **environment.network_settings)
        for genome, speed in zip((predator, prey), environment.max_wheel_speeds, strict=True)
    ]
    record = {name: [] for name in ('poses', 'readings', 'wheels', 'inputs', 'hidden', 'outputs')}
    record['poses'].append(np.copy(world.poses))
    captured = False
    while not captured and len(record['wheels']) < environment.episode_ticks:
        readings = np.copy(world.readings)
        wheels = np.stack([np.copy(c.step(r)) for c, r in zip(controllers, readings, strict=True)])
        captured = world.step(wheels)
        record['readings'].append(readings)
        record['wheels'].append(wheels)
        for name in ('inputs', 'hidden', 'outputs'):
            record[name].append(np.stack([np.copy(getattr(c, name)) for c in controllers]))
        record['poses'].append(np.copy(world.poses))
    return {name: np.array(values) for name, values in record.items()}, captured


def test_the_robots_stepped_one_by_one_equal_the_fused_kernel_bit_for_bit(results):
    environment, predators, prey, i, j, ticks, complexity = results
    early = np.flatnonzero(ticks < ticks.max())[:6]
    for k in np.concatenate([early, np.flatnonzero(ticks == ticks.max())[:2]]):
        predator, quarry = predators[i[k]], prey[j[k]]
        record, captured = driven(predator, quarry, environment)
        assert len(record['wheels']) == ticks[k]
        trace = trace_pair(predator, quarry, environment)
        assert trace.ticks == ticks[k]
        assert bool(trace.captured) == captured
        for name, values in record.items():
            ours = getattr(trace, name)
            assert ours.dtype == np.float32
            assert ours.tobytes() == values.astype(np.float32).tobytes(), name
        # the complexity holds every wheel command of the fused kernel: equal bits, equal behaviour
        left, right = np.moveaxis(record['wheels'], -1, 0)
        half = np.float32(0.5)
        speeds = np.stack([(left + right) * half, (right - left) * half])
        steps = np.abs(np.diff(speeds, axis=1, prepend=np.float32(0)))
        variation = np.cumsum(steps[0] + steps[1], axis=0, dtype=np.float32)[-1]
        assert (
            complexity[k] == (variation.astype(float) / (2 * ticks[k])).astype(np.float32)
        ).all()

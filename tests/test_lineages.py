"""Lineages in a stream against lineages followed step by step."""

import dataclasses

import numpy as np
import pytest
from lineages import follow, random_lineages

from coevo_manager.core.episodes import Environment, EpisodeStream, evaluate_pairs
from coevo_manager.core.evaluation import all_pairs
from coevo_manager.core.local_evaluator import LocalEvaluator
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.genome import random_genomes

ENVIRONMENTS = {
    'open': Environment(episode_ticks=200),
    'obstacle': Environment(obstacle=True, motor_map='printed', episode_ticks=200),
    'perturbed': Environment(
        episode_ticks=200,
        perturbations=Perturbations(infrared_noise=0.01, start_displacement=0.1, latency_ticks=1),
    ),
    'repeated': Environment(
        episode_ticks=100,
        repetitions=3,
        perturbations=Perturbations(camera_noise=0.1, start_displacement=0.3, start_rotation=3.0),
    ),
    'pymunk': Environment(physics='pymunk', episode_ticks=60),
}


@pytest.fixture(scope='module', params=ENVIRONMENTS)
def works(request):
    """An environment, lineages and batches to play there, and what must come of them."""
    environment = ENVIRONMENTS[request.param]
    rng = np.random.default_rng(5)
    generations = 4 if environment.physics == 'pymunk' else 12
    works, expected, accepted = [], [], 0
    for number in range(8):
        species = ('predator', 'prey')[number % 2]
        lineages = random_lineages(
            rng, species, environment, 1 + number % generations, 3, count=1 + number % 3
        )
        if number in (2, 4):  # predators whose offspring all fail
            none = np.ones_like(lineages.parent_ticks)
            lineages = dataclasses.replace(lineages, parent_ticks=none)
        ticks, count = follow(lineages, environment)
        works.append(lineages)
        expected.append(ticks)
        accepted += count
    generations = sum(lineages.redrawn.size for lineages in works)
    assert 0 < accepted < generations
    for count in (1, 5):
        batch = all_pairs('prey', random_genomes(count, rng), random_genomes(4, rng))
        works.append(batch)
        expected.append(
            evaluate_pairs(
                batch.predators, batch.prey, batch.predator_index, batch.prey_index, environment
            )
        )
    return environment, works, expected


@pytest.mark.parametrize('seed', range(3))
def test_a_stream_plays_lineages_as_if_each_were_alone(works, seed):
    environment, works, expected = works
    rng = np.random.default_rng(seed)
    rest = rng.permutation(np.tile(np.arange(len(works)), 2)).tolist()
    asked = len(rest)
    stream, seen = EpisodeStream(environment), []
    while rest or stream.pending:
        while rest and (not stream.pending or rng.random() < 0.3):
            number = rest.pop()
            work = works[number]
            if number < 8:
                stream.submit_lineages(number, work)
            else:
                index = work.predator_index, work.prey_index
                stream.submit(number, work.predators, work.prey, *index)
        for number, ticks, _ in stream.advance():
            seen.append(number)
            np.testing.assert_array_equal(ticks, expected[number])
    assert len(seen) == asked


@pytest.mark.parametrize('threads', [1, 2])
def test_the_local_evaluator_plays_both(works, threads):
    environment, works, expected = works
    evaluator = LocalEvaluator(environment, threads)
    forgotten = evaluator.submit(works[0])
    evaluator.cancel()
    tickets = {evaluator.submit(work): number for number, work in enumerate(works)}
    for _ in works:
        ticket, ticks = evaluator.collect()
        assert ticket != forgotten
        np.testing.assert_array_equal(ticks, expected[tickets.pop(ticket)])
    assert not tickets and evaluator.collect() is None
    evaluator.close()


def test_lineages_of_unequal_length_end_together():
    environment = Environment(episode_ticks=50)
    rng = np.random.default_rng(1)
    stream = EpisodeStream(environment)
    for generations in (10, 30):
        stream.submit_lineages(
            generations, random_lineages(rng, 'prey', environment, generations, 8)
        )
    turns_left = None
    while stream.pending:
        if stream.advance() and turns_left is None:
            turns_left = 0
        elif turns_left is not None:
            turns_left += 1
    # Alone, each generation is a turn or more: played in turns, 20 of them would be left.
    assert turns_left < 10


def test_no_batch_waits_for_lineages_for_ever():
    environment = Environment(episode_ticks=50)
    rng = np.random.default_rng(1)
    stream = EpisodeStream(environment)
    batch = all_pairs('predator', random_genomes(10, rng), random_genomes(4, rng))
    stream.submit('batch', batch.predators, batch.prey, batch.predator_index, batch.prey_index)
    for number in range(4):
        stream.submit_lineages(number, random_lineages(rng, 'prey', environment, 40, 8))
    while not (ended := stream.advance()):
        pass
    assert [ticket for ticket, _, _ in ended] == ['batch']


def test_a_request_is_taken_up_while_another_leaves_lanes_idle():
    environment = Environment(episode_ticks=400)
    rng = np.random.default_rng(2)
    stream = EpisodeStream(environment)
    stream.submit_lineages('long', random_lineages(rng, 'prey', environment, 50, 1))
    assert stream.advance() == [] and stream.pending == 1

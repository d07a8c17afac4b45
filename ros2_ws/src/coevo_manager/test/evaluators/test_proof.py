"""What is wrong with an answer, and the episode of it that is played again."""

import numpy as np
import pytest
from lineages import follow, random_lineages

from coevo_manager.core.episodes import Environment, evaluate_pairs
from coevo_manager.core.evaluation import all_pairs
from coevo_manager.evaluators.proof import fault, sample
from neuro_controller.core.genome import random_genomes

ENVIRONMENT = Environment(episode_ticks=150)
BATCH = all_pairs(
    'prey',
    random_genomes(3, np.random.default_rng(1)),
    random_genomes(4, np.random.default_rng(2)),
)


def play(batch):
    return evaluate_pairs(
        batch.predators, batch.prey, batch.predator_index, batch.prey_index, ENVIRONMENT
    )


@pytest.mark.parametrize(
    ('ticks', 'sentence'),
    [
        ([1] * 12, ''),
        ([150] * 12, ''),
        ([1] * 11 + [151], 'answered tick 151, expected 1 to 150'),
        ([2**31 - 1] * 12, 'answered tick 2147483647, expected 1 to 150'),
        ([-5] + [1] * 11, 'answered tick -5, expected 1 to 150'),
        ([1] * 6 + [0] * 6, 'answered tick 0, expected 1 to 150'),
        ([1] * 11, 'answered 11 episodes of 12'),
        ([1] * 13, 'answered 13 episodes of 12'),
        ([], 'answered 0 episodes of 12'),
    ],
)
def test_the_form_of_an_answer(ticks, sentence):
    assert fault(BATCH, True, '', np.array(ticks, np.int32), 150) == sentence


def test_an_evaluator_that_refuses():
    nothing = np.empty(0, np.int32)
    assert fault(BATCH, False, 'out of order', nothing, 150) == 'refused its work: out of order'


def test_samples_of_a_batch_replay_every_episode():
    ticks, rng = play(BATCH), np.random.default_rng(3)
    seen = set()
    for _ in range(100):
        batch, tick = sample(BATCH, ticks, rng)
        assert play(batch).tolist() == [tick]
        seen.add((batch.predators.tobytes(), batch.prey.tobytes()))
    assert len(seen) == 12


@pytest.mark.parametrize('species', ['predator', 'prey'])
def test_samples_of_a_lineage_replay_the_offspring_of_its_generation(species):
    rng = np.random.default_rng(10)
    lineages = random_lineages(rng, species, ENVIRONMENT, generations=20, count=3)
    ticks, accepted = follow(lineages, ENVIRONMENT)
    assert 0 < accepted < 60
    for _ in range(60):
        batch, tick = sample(lineages, ticks, rng)
        assert play(batch).tolist() == [tick]


def test_a_lineage_with_one_false_outcome_is_found_out_by_what_follows():
    rng = np.random.default_rng(10)
    lineage = random_lineages(rng, 'prey', ENVIRONMENT, generations=20)
    ticks, _ = follow(lineage, ENVIRONMENT)
    ticks[:3] = 150  # the first offspring is accepted, and wrongly so
    wrong = [tick for batch, tick in (sample(lineage, ticks, rng) for _ in range(60))
             if play(batch).tolist() != [tick]]  # fmt: skip
    assert len(wrong) > 3

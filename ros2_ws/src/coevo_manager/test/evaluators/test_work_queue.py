"""Parts handed out, lost, answered twice or late: the results are those of each batch alone."""

import itertools

import numpy as np
import pytest
from lineages import random_lineages

from coevo_manager.core.environment import Environment
from coevo_manager.core.evaluation import Batch, Lineages, all_pairs, joined
from coevo_manager.evaluators.work_queue import WorkQueue, split


def batch(rng, predators, prey):
    """A batch whose genomes are told apart by their first gene."""
    ours, theirs = np.zeros((predators, 442), np.float32), np.zeros((prey, 442), np.float32)
    ours[:, 0], theirs[:, 0] = rng.permutation(predators), rng.permutation(prey) / 4096
    return all_pairs('predator', ours, theirs)


def ticks(work):
    """An answer that names the genomes of each episode."""
    if isinstance(work, Lineages):
        return np.arange(len(work), dtype=np.int32) + 1
    pair = work.predators[work.predator_index, 0] + work.prey[work.prey_index, 0]
    return (pair * 4096).astype(np.int32)


@pytest.mark.parametrize('seed', range(5))
def test_results_are_right_whatever_is_lost_late_or_doubled(seed):
    rng = np.random.default_rng(seed)
    lineage = random_lineages(rng, 'prey', Environment(episode_ticks=20), 3, 2, count=2)
    works = [batch(rng, 80, 41), batch(rng, 1, 1), lineage, batch(rng, 16, 16)]
    queue = WorkQueue()
    tickets = {queue.submit(work): work for work in works}
    under_way = []
    while queue.unfinished:
        part = queue.take()
        if part is not None:
            under_way.append(part)
        chance = rng.random()
        if under_way and chance < 0.3:
            assert queue.give_back([under_way[rng.integers(len(under_way))]]) in (0, 1)
        elif under_way and chance < 0.7:
            part = under_way[rng.integers(len(under_way))]
            queue.accept(part, ticks(part.work))
    finished = [queue.finished() for _ in works]
    assert queue.finished() is None and queue.take() is None
    for ticket, result in finished:
        np.testing.assert_array_equal(result, ticks(tickets.pop(ticket)))
    assert not tickets


def test_what_was_given_back_goes_first():
    queue = WorkQueue()
    rng = np.random.default_rng(1)
    for _ in range(4):
        queue.submit(batch(rng, 2, 2))
    first, second = queue.take(), queue.take()
    assert queue.give_back([first, second]) == 2
    assert [queue.take() for _ in range(2)] == [first, second]


def test_what_was_cancelled_is_neither_handed_out_nor_taken():
    queue = WorkQueue()
    rng = np.random.default_rng(1)
    old = queue.submit(batch(rng, 30, 30))
    under_way = queue.take()
    queue.cancel()
    assert not queue.unfinished and queue.take() is None
    assert queue.give_back([under_way]) == 0
    queue.accept(under_way, ticks(under_way.work))
    assert queue.finished() is None
    assert queue.submit(batch(rng, 2, 2)) != old


def test_parts_are_equal_and_have_just_the_genomes_they_need():
    work = batch(np.random.default_rng(2), 30, 30)
    parts = list(split(5, work, 256))
    lengths = [len(part.work) for part in parts]
    assert sum(lengths) == 900 and max(lengths) <= 256
    assert max(lengths) - min(lengths) <= 1
    assert [part.place.start for part in parts] == [0, *itertools.accumulate(lengths)][:-1]
    for part in parts:
        np.testing.assert_array_equal(ticks(part.work), ticks(work)[part.place])
        used = np.unique(part.work.predator_index), np.unique(part.work.prey_index)
        assert [len(genomes) for genomes in used] == [
            len(part.work.predators),
            len(part.work.prey),
        ]


def test_joined_batches_are_each_of_them_in_turn():
    rng = np.random.default_rng(3)
    prey = batch(rng, 1, 7).prey
    works = [all_pairs('predator', batch(rng, n, 1).predators, prey) for n in (4, 1, 9)]
    together = joined(works)
    assert together.prey is prey and len(together.predators) == 14
    works.append(batch(rng, 3, 5))
    for some, all_of_them in ((works[:3], together), (works, joined(works))):
        expected = np.concatenate([ticks(work) for work in some])
        np.testing.assert_array_equal(ticks(all_of_them), expected)
    assert joined(works[:1]) is works[0]


def test_a_batch_that_is_short_enough_is_sent_as_it_is():
    genomes = np.zeros((3, 442), np.float32)
    work = Batch(genomes, genomes, np.zeros(7, np.uint32), np.zeros(7, np.uint32))
    (part,) = split(1, work, 7)
    assert part.work is work

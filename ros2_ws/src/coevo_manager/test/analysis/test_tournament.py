"""Post-evaluation: orientation, store, continuation, cluster, probe."""

import os
import subprocess
import sys
from dataclasses import dataclass, field

import numpy as np
import pytest

from coevo_manager.analysis.pipeline import connect
from coevo_manager.analysis.play.kernel import PACKAGES, Kernel, source_hash, sources
from coevo_manager.analysis.play.probe import (
    SearchBudget,
    best_found,
    best_response,
    candidates_needed,
    probe,
    while_searching,
)
from coevo_manager.analysis.play.tournament import Block, Evaluations, Store, evaluate_portion
from coevo_manager.analysis.runs import AnalysisError
from coevo_manager.core.episodes import Environment, evaluate_matrix, measure_pairs

SHORT = Environment(episode_ticks=60)


@dataclass
class Toy:
    """Kernel whose predators of strength genome[0] catch prey of strength genome[0] sooner."""

    version: str = 'toy'
    calls: list = field(default_factory=list)
    fail_after: int | None = None

    def ticks(self, predators, prey, predator_index, prey_index, environment):
        if self.fail_after is not None and len(self.calls) >= self.fail_after:
            raise KeyboardInterrupt
        self.calls.append(len(predator_index))
        margin = prey[prey_index, 0] - predators[predator_index, 0]
        return np.round(environment.episode_ticks / (1 + np.exp(-margin))).astype(np.int32)

    def measure(self, *arguments):
        ticks = self.ticks(*arguments)
        return ticks, np.stack([ticks, -ticks], axis=1).astype(np.float32)


def genomes(seed, count=6):
    return np.random.default_rng(seed).uniform(-5, 5, (count, 442)).astype(np.float32)


def evaluations(tmp_path, kernel, **options):
    return Evaluations(kernel, Store(tmp_path / 'cache', kernel.version), **options)


def test_rows_are_predators_and_columns_prey(tmp_path):
    weak, strong = np.zeros((2, 442), np.float32), np.full((3, 442), 3, np.float32)
    result = evaluations(tmp_path, Toy())[Block(strong, weak, Environment(), complexity=True)]
    assert result.fitness.shape == (3, 2)
    assert result.fitness.min() > 0.9  # strong predators catch weak prey
    assert result.complexity.shape == (3, 2, 2)
    assert (result.complexity[..., 0] > 0).all()  # predator first
    reverse = evaluations(tmp_path, Toy())[Block(weak, strong, Environment())]
    assert reverse.fitness.max() < 0.1


def test_blocks_are_what_the_core_gives(tmp_path):
    predators, prey = genomes(1, 4), genomes(2, 3)
    found = evaluations(tmp_path, Kernel())
    expected = 1 - evaluate_matrix(predators, prey, SHORT) / 60
    assert found[Block(predators, prey, SHORT)].fitness == pytest.approx(expected)
    measured = found[Block(predators, prey, SHORT, complexity=True)]
    _, complexity = measure_pairs(predators, prey, [2], [1], SHORT)
    assert measured.complexity[2, 1] == pytest.approx(complexity[0])


def test_portions_keep_blocks_apart():
    blocks = [Block(genomes(k, 2 + k), genomes(9 - k, 4), SHORT) for k in range(3)]
    together = evaluate_portion(Toy(), blocks)
    for block, arrays in zip(blocks, together, strict=True):
        alone = evaluate_portion(Toy(), [block])[0]['ticks']
        assert np.array_equal(arrays['ticks'], alone)
        assert arrays['ticks'].shape == (len(block.predators), 4)


def test_a_replication_more_evaluates_only_what_is_new(tmp_path):
    kernel = Toy()
    first = [Block(genomes(a), genomes(10 + b), SHORT) for a in range(2) for b in range(2)]
    assert evaluations(tmp_path, kernel).prepare(first) == 4 * 36
    done = []
    more = [*first, Block(genomes(7), genomes(8), SHORT)]
    assert evaluations(tmp_path, kernel).prepare(more, done.append) == 36
    assert sum(done) == 5 * 36
    same = Block(genomes(0).copy(), genomes(10).copy(), Environment(episode_ticks=60))
    assert evaluations(tmp_path, kernel).prepare([same, same]) == 0


def test_what_decides_an_episode_decides_the_key(tmp_path):
    block = Block(genomes(1), genomes(2), SHORT)
    others = [
        Block(genomes(2), genomes(1), SHORT),
        Block(genomes(1), genomes(2), SHORT, complexity=True),
        Block(genomes(1), genomes(2), Environment(episode_ticks=61)),
        Block(genomes(1, 3), genomes(2), SHORT),
    ]
    assert len({block.digest, *(other.digest for other in others)}) == 5
    store = Store(tmp_path, 'one')
    store.save(block.digest, ticks=np.zeros(1))
    assert block.digest in store
    assert block.digest not in Store(tmp_path, 'two')  # another version of the kernel


def test_an_interrupted_tournament_continues(tmp_path):
    blocks = [Block(genomes(a, 72), genomes(20 + a, 72), SHORT) for a in range(4)]
    with pytest.raises(KeyboardInterrupt):
        evaluations(tmp_path, Toy(fail_after=2)).prepare(blocks)
    kernel = Toy()
    played = evaluations(tmp_path, kernel).prepare(blocks)
    assert 0 < played < 4 * 72 * 72
    assert sum(kernel.calls) == played


def test_a_damaged_result_is_evaluated_anew(tmp_path):
    found = evaluations(tmp_path, Toy())
    block = Block(genomes(1), genomes(2), SHORT)
    before = found[block].fitness
    path = found.store.path(block.digest)
    path.write_bytes(path.read_bytes()[:40])
    assert np.array_equal(found[block].fitness, before)
    assert found.store.load(block.digest) is not None


def test_nothing_half_written_is_left(tmp_path, monkeypatch):
    store = Store(tmp_path, 'v')

    def fail(file, **arrays):
        file.write(b'half')
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(np, 'savez_compressed', fail)
    with pytest.raises(OSError, match='No space'):
        store.save('digest', ticks=np.zeros(3))
    assert [path for path in tmp_path.rglob('*') if path.is_file()] == []


def test_a_dask_cluster_gives_the_same(tmp_path):
    from distributed import LocalCluster

    blocks = [Block(genomes(a), genomes(5 + a), SHORT) for a in range(3)]
    alone = evaluations(tmp_path / 'alone', Kernel(), workers=2)
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, memory_limit=0
        ) as cluster,
        connect(cluster.scheduler_address, source_hash()) as client,
    ):
        with pytest.raises(AnalysisError, match='another version of the episode kernel'):
            connect(cluster.scheduler_address, 'older')
        together = evaluations(tmp_path / 'cluster', Kernel(), client=client)
        assert together.prepare(blocks) == 3 * 36
        processes = set(client.run(os.getpid).values())
        budget = SearchBudget(candidates=4, searches=2)
        spread = probe(together, genomes(3, 2), 'prey', SHORT, budget)
    assert os.getpid() not in processes
    for block in blocks:
        assert np.array_equal(together[block].fitness, alone[block].fitness)
    assert np.array_equal(spread, probe(alone, genomes(3, 2), 'prey', SHORT, budget))


def test_the_probe_finds_the_best_response(tmp_path):
    """Of the toy, the best response is the greatest first gene: fitness 1 / (1 + exp(a - 5))."""
    budget = SearchBudget(candidates=400, searches=4)
    for species in ('predator', 'prey'):
        champions = np.zeros((2, 442), np.float32)
        champions[1, 0] = 4
        found = probe(evaluations(tmp_path, Toy()), champions, species, Environment(), budget)
        assert found.shape == (2, 4, 400)
        assert (np.diff(found, axis=-1) >= 0).all()
        best = best_found(found)
        assert best[0] == pytest.approx(1 / (1 + np.exp(-5)), abs=0.01)
        assert best[1] == pytest.approx(1 / (1 + np.exp(-1)), abs=0.06)
        assert while_searching(found)[1] < while_searching(found)[0] < best[0]


def test_candidates_needed_by_hand():
    history = np.array([[0.1, 0.5, 0.9], [0.2, 0.3, 0.4]])  # the second search finds no winner
    assert candidates_needed(history) == (2 + 3) / 2


def test_the_hashed_sources_are_all_that_playing_an_episode_imports():
    script = (
        'import sys, coevo_manager.core.episodes\n'
        'print(*(m for m in sys.modules if m.partition(".")[0] in sys.argv[1:]))'
    )
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, '-c', script, *PACKAGES]
    output = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    loaded = set(output.stdout.split())
    assert 'coevo_manager.core.episodes.schedule' in loaded
    assert set(sources()) >= loaded
    assert not [name for name in sources() if name.startswith('coevo_manager.core.evolution')]


def test_the_probe_is_repeatable_and_bounded_by_its_budget():
    kernel = Toy()
    budget = SearchBudget(candidates=7, searches=3)
    first = best_response(kernel, genomes(1, 1)[0], 'prey', SHORT, budget)
    assert sum(kernel.calls) == 7 * 3
    assert np.array_equal(first, best_response(Toy(), genomes(1, 1)[0], 'prey', SHORT, budget))

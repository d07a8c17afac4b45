"""Runs that are killed, stopped, damaged or out of space go on as if nothing had happened."""

import contextlib
import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from evolve_runs import read_files
from full_disk import full_disk
from ros_processes import wait_until

from coevo_manager.core.evolution import (
    Evolution,
    PhaseStats,
    RunFolderError,
    checkpoint,
    load_configuration,
)
from coevo_manager.core.local_evaluator import LocalEvaluator

VALUES = {
    'population': 16,
    'selected': 4,
    'phases': 12,
    'generations': 5,
    'swap_generations': 10,
    'snapshot_generations': 15,
    'episode_ticks': 150,
    'algorithm': 'hall_of_fame',
}


def evaluator_of(configuration):
    return LocalEvaluator(configuration.make_environment())


def run_whole(folder, configuration):
    assert Evolution(configuration, evaluator_of(configuration), folder).run().finished
    return read_files(folder)


def stop_after(folder, configuration, phase):
    """Run a few phases, as a process that ended there would leave them."""

    def observer(stats):
        if stats.phase == phase + 1:
            evolution.stop()

    evolution = Evolution(configuration, evaluator_of(configuration), folder, observer)
    assert not evolution.run().finished


def resume(folder, configuration=None):
    held = configuration or load_configuration(VALUES)
    return Evolution.resume(folder, evaluator_of(held), configuration=configuration).run()


@pytest.fixture(scope='module')
def whole(tmp_path_factory):
    return run_whole(tmp_path_factory.mktemp('whole') / 'run', load_configuration(VALUES))


def go_on(folder, configuration, slots):
    """Start or continue a run."""
    evaluator = evaluator_of(configuration)
    evaluator.slots = slots
    if (folder / 'run.json').exists():
        evolution = Evolution.resume(folder, evaluator)
    else:
        evolution = Evolution(configuration, evaluator, folder)
    evolution.run()


def test_killed_again_and_again(tmp_path):
    """kill -9 at random moments, till the run is through; in one slot and in three."""
    configuration = load_configuration({**VALUES, 'phases': 72})
    expected = run_whole(tmp_path / 'whole', configuration)
    rng = random.Random(4)
    for slots in (1, 3):
        folder = tmp_path / f'killed{slots}'
        kills = 0
        ended = None
        while ended != 0:
            # Forked, so that the episode kernel is loaded already and the kill hits the run.
            process = multiprocessing.get_context('fork').Process(
                target=go_on, args=(folder, configuration, slots)
            )
            process.start()
            process.join(rng.uniform(0.01, 0.15) + 0.01 * kills)  # a slow machine ends as well
            if process.exitcode is None:
                process.kill()
                kills += 1
            process.join(10)
            ended = process.exitcode
            assert ended in (0, -signal.SIGKILL)
        assert read_files(folder) == expected
        assert kills > 1


def test_what_a_run_leaves_that_never_began_is_no_hindrance(tmp_path, whole):
    folder = tmp_path / 'run'
    for name in ('snapshots', 'checkpoint'):
        (folder / name).mkdir(parents=True)
    (folder / 'run.log').touch()
    (folder / 'run.json.12345678.partial').write_text('{')
    (folder / 'snapshots' / 'mine').touch()
    configuration = load_configuration(VALUES)
    with pytest.raises(RunFolderError, match='is not empty'):
        Evolution(configuration, evaluator_of(configuration), folder)
    (folder / 'snapshots' / 'mine').unlink()
    assert Evolution(configuration, evaluator_of(configuration), folder).run().finished
    assert {n: c for n, c in read_files(folder).items() if 'partial' not in n} == whole


@pytest.mark.parametrize('phase', [0, 1, 5])
def test_a_stopped_run_goes_on(tmp_path, whole, phase):
    stop_after(tmp_path / 'run', load_configuration(VALUES), phase)
    assert len(list((tmp_path / 'run' / 'checkpoint').iterdir())) == min(phase + 1, 2)
    assert resume(tmp_path / 'run').finished
    assert read_files(tmp_path / 'run') == whole


def test_a_run_ended_before_its_first_checkpoint_goes_on(tmp_path, whole):
    configuration = load_configuration(VALUES)
    evolution = Evolution(configuration, evaluator_of(configuration), tmp_path / 'run')
    evolution.stop()
    assert not evolution.run().finished
    assert resume(tmp_path / 'run').finished
    assert read_files(tmp_path / 'run') == whole


def test_a_finished_run_stays_as_it_is(tmp_path, whole):
    run_whole(tmp_path / 'run', load_configuration(VALUES))
    assert resume(tmp_path / 'run').finished
    assert read_files(tmp_path / 'run') == whole


def truncate(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def empty(path):
    path.write_bytes(b'')


def flip_a_gene(path):
    """Change the content and keep the archive's own checksums right."""
    with np.load(path) as file:
        arrays = dict(file)
    arrays['predators'][3, 100] += 1
    with path.open('wb') as file:
        np.savez(file, **arrays)


def flip_a_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


@pytest.mark.parametrize('damage', [truncate, empty, flip_a_gene, flip_a_bit])
def test_a_damaged_checkpoint_is_passed_over(tmp_path, whole, damage):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 5)
    damage(folder / 'checkpoint' / 'phase_000005.npz')
    assert resume(folder).finished
    assert read_files(folder) == whole
    log = (folder / 'run.log').read_text()
    assert 'phase_000005.npz is damaged' in log
    assert 'resumed after phase 4, generation 20' in log


def test_a_pickle_is_never_loaded(tmp_path):
    class Trap:
        def __reduce__(self):
            return Path.touch, (tmp_path / 'sprung',)

    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 2)
    for path in (folder / 'checkpoint').iterdir():
        np.savez(path, version=np.array([Trap()], object), sha256=np.array([Trap()], object))
    with pytest.raises(RunFolderError, match=r'cannot go on: .* is damaged'):
        resume(folder)
    assert not (tmp_path / 'sprung').exists()


def test_without_any_sound_checkpoint_nothing_is_touched(tmp_path):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 2)
    for path in (folder / 'checkpoint').iterdir():
        truncate(path)
    before = read_files(folder)
    with pytest.raises(RunFolderError, match=r'cannot go on: .*; .*'):
        resume(folder)
    assert read_files(folder) == before


@pytest.mark.parametrize(
    'name',
    ['generations.csv', 'hall_prey.bin', 'snapshots/gen_000000.npz', 'snapshots/gen_000015.npz'],
)
@pytest.mark.parametrize('damage', [truncate, flip_a_bit, Path.unlink])
def test_damage_that_the_run_would_carry_on_is_refused(tmp_path, name, damage):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 5)
    damage(folder / name)
    before = read_files(folder)
    with pytest.raises(RunFolderError, match=f'{name} (is damaged|cannot be read): '):
        resume(folder)
    assert read_files(folder) == before


def test_damage_after_the_checkpoint_before_is_made_good(tmp_path, whole):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 5)
    path = folder / 'phases.csv'
    content = bytearray(path.read_bytes())
    content[-3] ^= 1
    path.write_bytes(content)
    assert resume(folder).finished
    assert read_files(folder) == whole
    log = (folder / 'run.log').read_text()
    assert 'phases.csv is damaged: its first' in log
    assert 'resumed after phase 4, generation 20' in log


def resigned(path, **changes):
    """Change a checkpoint and sign it anew."""
    with np.load(path) as file:
        arrays = {name: array for name, array in file.items() if name != 'sha256'}
    arrays |= changes
    arrays = {name: array for name, array in arrays.items() if array is not None}
    arrays['sha256'] = np.array(checkpoint._digest(arrays))
    with path.open('wb') as file:
        np.savez(file, **arrays)


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'prey': None}, "it lacks 'prey'"),
        ({'snapshots': None}, "it lacks 'snapshots'"),
        ({'hall_prey_size': None, 'hall_prey_sha256': None}, "it lacks 'hall_prey'"),
        ({'prey_memory': np.zeros((2, 3))}, r'prey_memory has shape \(2, 3\)'),
        ({'prey': np.zeros((3, 442), np.float32)}, 'its populations are not of 16'),
        ({'capture_ticks': np.zeros((16, 16), np.int32)}, 'does not lie in 1 to 150'),
        ({'capture_ticks': np.ones((16, 16))}, 'of float64'),
        ({'evolving': np.array('cat')}, "evolving is 'cat'"),
        ({'ticks': np.int64(-1)}, 'is negative'),
        ({'snapshots': np.arange(3)}, 'zip'),
    ],
)
def test_a_checkpoint_that_makes_no_sense_is_refused(tmp_path, changes, sentence):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 0)
    resigned(folder / 'checkpoint' / 'phase_000000.npz', **changes)
    with pytest.raises(RunFolderError, match=f'phase_000000.npz is damaged: .*{sentence}'):
        resume(folder)


@pytest.mark.parametrize('name', ['run.log', 'generations.csv', 'phases.csv', 'snapshots'])
def test_links_are_not_written_through(tmp_path, name):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 1)
    target = tmp_path / 'target'
    (folder / name).rename(target)
    before = target.read_bytes() if target.is_file() else read_files(target)
    (folder / name).symlink_to(target)
    with pytest.raises(RunFolderError, match=f'{name} is a symbolic link'):
        resume(folder)
    assert (target.read_bytes() if target.is_file() else read_files(target)) == before


@pytest.mark.timeout(60)
@pytest.mark.parametrize('name', ['run.log', 'generations.csv', 'run.json'])
def test_pipes_are_not_waited_for(tmp_path, name):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 1)
    (folder / name).unlink()
    os.mkfifo(folder / name)
    with pytest.raises(ValueError, match=name):
        resume(folder)


def test_a_link_in_place_of_a_file_is_replaced(tmp_path, whole):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 5)
    (tmp_path / 'target').write_text('mine')
    for name in ('report.md', 'snapshots/gen_000030.npz', 'checkpoint/phase_000006.npz'):
        (folder / name).symlink_to(tmp_path / 'target')
    assert resume(folder).finished
    assert read_files(folder) == whole
    assert (tmp_path / 'target').read_text() == 'mine'


def test_another_configuration_is_refused(tmp_path):
    folder = tmp_path / 'run'
    stop_after(folder, load_configuration(VALUES), 1)
    before = read_files(folder)
    with pytest.raises(RunFolderError, match=r'\(there, here\): seed: 1, 2; mutation_rate: 0.02'):
        resume(folder, load_configuration({**VALUES, 'seed': 2, 'mutation_rate': 0.05}))
    assert read_files(folder) == before


def test_a_checkpoint_of_another_run_is_refused(tmp_path):
    other, folder = tmp_path / 'other', tmp_path / 'run'
    stop_after(other, load_configuration({**VALUES, 'seed': 2}), 3)
    stop_after(folder, load_configuration(VALUES), 1)
    for path in (other / 'checkpoint').iterdir():
        (folder / 'checkpoint' / path.name).write_bytes(path.read_bytes())
    assert resume(folder).finished
    log = (folder / 'run.log').read_text()
    assert log.count('belongs to a run of another configuration') == 2
    assert 'resumed after phase 1,' in log


def test_a_checkpoint_from_before_a_field_was_there_is_of_the_same_run(tmp_path):
    folder = tmp_path / 'run'
    configuration = load_configuration(VALUES)
    stop_after(folder, configuration, 1)
    before = {k: v for k, v in configuration.as_dict().items() if k != 'fresh_noise'}
    path = folder / 'checkpoint' / 'phase_000001.npz'
    resigned(path, configuration=np.array(json.dumps(before)))
    assert checkpoint.load(path, configuration)[0].phase == 1


def test_a_checkpoint_of_another_version_is_named(tmp_path, monkeypatch):
    folder = tmp_path / 'run'
    monkeypatch.setattr(checkpoint, 'VERSION', 9)
    stop_after(folder, load_configuration(VALUES), 0)
    monkeypatch.undo()
    with pytest.raises(RunFolderError, match='has format version 9, this program reads 3'):
        resume(folder)


@pytest.mark.parametrize('content', [None, 'nonsense', '{}', '{"version": 9}', '[]'])
def test_a_folder_without_a_run_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / 'run.json').write_text(content)
    with pytest.raises(RunFolderError, match=r'holds no run|run\.json is damaged'):
        resume(tmp_path)


def test_two_processes_do_not_share_a_folder(tmp_path):
    folder = tmp_path / 'run'
    configuration = load_configuration({**VALUES, 'phases': 100_000})
    run_in_use = Evolution(configuration, evaluator_of(configuration), folder)
    code = f"""
from coevo_manager.core.local_evaluator import LocalEvaluator
from coevo_manager.core.evolution import Evolution, load_configuration
environment = load_configuration({VALUES}).make_environment()
Evolution.resume({str(folder)!r}, LocalEvaluator(environment))
"""
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(p for p in sys.path if p)}
    other = subprocess.run(
        [sys.executable, '-c', code], env=environment, capture_output=True, text=True, timeout=60
    )
    assert f'another process is running in {folder}' in other.stderr
    run_in_use.stop()
    run_in_use.run()
    resumed = Evolution.resume(folder, evaluator_of(configuration))
    resumed.stop()
    assert not resumed.run().finished


@pytest.mark.parametrize(
    ('victim', 'phase', 'size'),
    [
        ('checkpoint', 3, 40_000),
        ('snapshots/gen_000015.npz', 2, 40_000),
        ('generations.csv', 2, 800),
    ],
)
def test_a_full_disk_loses_nothing(tmp_path, whole, victim, phase, size):
    folder = tmp_path / 'run'
    configuration = load_configuration(VALUES)

    def observer(stats):
        if isinstance(stats, PhaseStats) and stats.phase == phase:
            checkpoint = folder / 'checkpoint' / f'phase_{phase:06d}.npz'
            wait_until(checkpoint.exists, f'the checkpoint of phase {phase}')
            disk.enter_context(full_disk(size))

    evolution = Evolution(configuration, evaluator_of(configuration), folder, observer)
    with (
        contextlib.ExitStack() as disk,
        pytest.raises(RunFolderError, match=rf'cannot write .*{victim}: File too large; every'),
    ):
        evolution.run()
    assert not list(folder.rglob('*.partial'))
    assert resume(folder).finished
    assert read_files(folder) == whole

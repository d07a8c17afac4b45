"""evolve as a user runs it: real processes, real services."""

import csv
import json
import re
import signal
import sys

import numpy as np
import pytest
from evolve_runs import TOY, evaluators_of, phases_completed, read_files, toy_files
from ros_processes import has_ended, wait_until

from coevo_manager.core.episodes import evaluate_matrix
from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.runs import evolve
from coevo_manager.runs.options import read_options
from coevo_manager.runs.run import make_plan
from node_runner.children import executable_path

LONG = ('--phases', '400')
"""A run that cannot be over before every evaluator of it is at work."""


@pytest.fixture(scope='module')
def long_files(tmp_path_factory):
    """The files of the toy run of LONG, played in this process."""
    return toy_files(tmp_path_factory.mktemp('long') / 'run', *LONG)


@pytest.fixture(scope='module')
def toy(tmp_path_factory):
    """The files of the toy run, played in this process."""
    return toy_files(tmp_path_factory.mktemp('toy') / 'run')


def test_two_phases_leave_a_readable_run(start, tmp_path):
    out = tmp_path / 'deep' / 'run'
    options = ['--population', '8', '--selected', '2', '--generations', '3', '--seed', '7']
    options += ['--environment', 'obstacle', '--motor-map', 'signed', '--episode-ticks', '100']
    run = start(['coevo_manager', 'evolve', *options, '--phases', '2', '--out', out])
    assert run.wait() == 0, run.stderr_text
    assert f'The run is in {out}' in run.stdout_text
    assert 'What this run achieved' in run.stdout_text
    assert '\x1b' not in run.stdout_text
    configuration = json.loads((out / 'run.json').read_text())['configuration']
    assert configuration['seed'] == 7
    assert configuration['environment'] == 'obstacle'
    assert configuration['motor_map'] == 'signed'
    generations = list(csv.DictReader((out / 'generations.csv').open()))
    assert [row['generation'] for row in generations] == ['1', '2', '3', '4', '5', '6']
    assert [row['phase'] for row in generations] == ['1', '1', '1', '2', '2', '2']
    phases = list(csv.DictReader((out / 'phases.csv').open()))
    assert [row['phase'] for row in phases] == ['0', '1', '2']
    assert int(phases[-1]['episodes']) == 8 * 8 + 2 * (3 * 2 * 2 + 2 * 8)
    last = np.load(out / 'snapshots' / 'gen_000006.npz', allow_pickle=False)
    assert last['predators'].shape == last['prey'].shape == (8, 442)
    assert last['fitness'].shape == (8, 8)


def test_a_run_is_the_same_on_three_evaluators(start, tmp_path, toy):
    run = start(['coevo_manager', 'evolve', *TOY, '--evaluators', '3', '--out', tmp_path / 'b'])
    assert run.wait() == 0, run.stderr_text
    assert read_files(tmp_path / 'b') == toy


def test_evaluators_play_another_number_of_hidden_neurons(start, tmp_path):
    hidden = ['--hidden', '13', '--phases', '6']
    alone = toy_files(tmp_path / 'alone', *hidden)
    run = start(['coevo_manager', 'evolve', *TOY, *hidden, '--out', tmp_path / 'run'])
    assert run.wait() == 0, run.stderr_text
    assert read_files(tmp_path / 'run') == alone
    with np.load(tmp_path / 'run' / 'snapshots' / 'gen_000060.npz') as last:
        assert last['predators'].shape == last['prey'].shape == (16, 13 * 13 + 29 * 13 + 52)


@pytest.mark.timeout(180)
def test_killed_and_hung_evaluators_change_nothing(start, tmp_path, long_files):
    out = tmp_path / 'c'
    options = [*TOY, *LONG, '--evaluators', '2', '--patience', '1', '--out', out]
    run = start(['coevo_manager', 'evolve', *options])
    run.wait_for_output('all 2 evaluators are at work')
    first, second = evaluators_of(run.pid)
    first.send_signal(signal.SIGKILL)
    second.send_signal(signal.SIGSTOP)
    assert run.wait() == 0, run.stderr_text
    log = (out / 'run.log').read_text()
    assert re.search(r'evaluator \S+ ended by SIGKILL', log), log
    assert re.search(r'evaluator \S+ is late and was ended; its work .* goes to another', log), log
    assert ' joined' in log
    status = json.loads((out / 'status.json').read_text())
    assert status['phase'] == 400 and status['progress'] == 1
    assert len(status['evaluators']) == 2
    reasons = [loss['reason'] for loss in status['losses']]
    assert 'ended by SIGKILL' in reasons and 'is late and was ended' in reasons
    assert has_ended(first) and has_ended(second)
    assert read_files(out) == long_files


def test_public_evaluators_come_and_go(start, tmp_path, toy):
    out = tmp_path / 'd'
    first = start(['coevo_manager', 'evaluator'])
    first.wait_for_output('ready on /evaluator_')
    slow = [*TOY, '--evaluators', '--patience', '0.5', '--out', out]
    run = start(['coevo_manager', 'evolve', *slow])
    wait_until(lambda: phases_completed(out) >= 1, 'the first phase')
    first.send_signal(signal.SIGSTOP)
    run.wait_for_output('no evaluator is left')
    done = phases_completed(out)
    second = start(['coevo_manager', 'evaluator', '--ros-args', '-r', '__ns:=/helper'])
    wait_until(lambda: phases_completed(out) >= done + 2, 'a joiner that works')
    first.send_signal(signal.SIGCONT)  # its late answers are not wanted any more
    assert run.wait() == 0, run.stderr_text
    assert second.poll() is None
    log = (out / 'run.log').read_text()
    assert re.search(r'evaluator /evaluator_\w+/evaluate_batch is late; its work', log), log
    assert 'evaluator /helper/evaluate_batch joined' in log
    assert read_files(out) == toy


def test_ctrl_c_leaves_nothing_and_the_run_can_go_on(start, tmp_path, long_files):
    out = tmp_path / 'e'
    options = [*TOY, *LONG, '--evaluators', '2', '--out', out]
    run = start(['coevo_manager', 'evolve', *options])
    run.wait_for_output('all 2 evaluators are at work')
    wait_until(lambda: phases_completed(out) >= 2, 'two phases')
    evaluators = evaluators_of(run.pid)
    assert len(evaluators) == 2
    run.send_signal(signal.SIGINT)
    assert run.wait() == 130
    assert all(has_ended(process) for process in evaluators)
    assert f'evolve --resume {out}' in run.stdout_text
    assert phases_completed(out) < 400
    resumed = start(['coevo_manager', 'evolve', '--resume', out])
    assert resumed.wait(100) == 0, resumed.stderr_text
    assert read_files(out) == long_files


def test_ctrl_c_while_evaluators_start(start, tmp_path):
    run = start(['coevo_manager', 'evolve', '--out', tmp_path / 'f'])
    run.wait_for_output('evolving into')
    run.send_signal(signal.SIGINT)
    assert run.wait() == 130
    assert not (tmp_path / 'f').exists()


def test_evaluators_end_with_a_killed_run(start, tmp_path):
    out = tmp_path / 'g'
    run = start(['coevo_manager', 'evolve', *TOY, '--phases', '100000', '--out', out])
    wait_until(lambda: phases_completed(out) >= 1, 'a phase')
    evaluators = evaluators_of(run.pid)
    run.kill()
    wait_until(lambda: all(has_ended(process) for process in evaluators), 'their end')


def test_a_terminal_gets_a_progress_bar(start, tmp_path):
    options = ' '.join([*TOY, '--phases', '3', '--out', str(tmp_path / 'h')])
    recorded = tmp_path / 'screen'
    command = f'exec {executable_path("coevo_manager", "evolve")} {options}'
    run = start(
        ['/usr/bin/env', 'script', '--quiet', '--return', '--command', command, recorded],
        {'TERM': 'xterm-256color', 'COLUMNS': '200'},
    )
    assert run.wait() == 0, run.stdout_text
    screen = re.sub(r'\x1b\[[0-9;?]*[A-Za-z]', '', recorded.read_text())
    assert '\x1b[' in recorded.read_text()
    assert re.search(r'100% ━+ .*\n\s*phase 3/3, generation 30, ', screen), screen
    assert 'What this run achieved' in screen


def test_statistics_are_published_while_it_runs(start, tmp_path):
    listener = start([sys.executable, '-c', LISTENER])
    listener.wait_for_output('listening')
    run = start(['coevo_manager', 'evolve', *TOY, '--phases', '150', '--out', tmp_path / 'i'])
    assert run.wait() == 0, run.stderr_text
    assert listener.wait() == 0, listener.stderr_text
    heard = [json.loads(line) for line in listener.stdout_text.splitlines()[1:]]
    rows = {
        int(row['generation']): row
        for row in csv.DictReader((tmp_path / 'i' / 'generations.csv').open())
    }
    assert heard[-1]['generation'] == 1500
    for stats in heard:
        row = rows[stats['generation']]
        assert stats['evolving'] == row['evolving']
        assert stats['episodes'] == int(row['episodes'])
        assert stats['fitness_mean'] == pytest.approx(float(row['fitness_mean']), abs=1e-5)
        assert stats['predator_fitness'] + stats['prey_fitness'] == pytest.approx(1, abs=1e-5)
        assert stats['progress'] == pytest.approx(stats['generation'] / 1500, abs=1e-5)
    known = [stats for stats in heard if stats['seconds'] - heard[0]['seconds'] > 0.2]
    assert known and all(stats['ticks_per_second'] > 0 for stats in known)


LISTENER = """
import json, rclpy
from coevo_msgs.msg import GenerationStats
rclpy.init()
node = rclpy.create_node('listener')
heard = []
node.create_subscription(GenerationStats, 'generation_stats', heard.append, 100)
print('listening', flush=True)
while not heard or heard[-1].progress < 1:
    rclpy.spin_once(node, timeout_sec=1)
names = [n for n in GenerationStats.get_fields_and_field_types() if n != 'header']
for message in heard:
    stamp = message.header.stamp
    fields = {name: getattr(message, name) for name in names}
    print(json.dumps(fields | {'seconds': stamp.sec + stamp.nanosec / 1e9}))
"""


def test_predators_learn_in_the_quick_preset(start, tmp_path):
    out = tmp_path / 'j'
    run = start(['coevo_manager', 'evolve', '--phases', '6', '--out', out])
    assert run.wait(100) == 0, run.stderr_text
    snapshots = sorted((out / 'snapshots').iterdir())
    first, last = (np.load(path, allow_pickle=False) for path in (snapshots[0], snapshots[-1]))
    prey = first['prey']
    before, after = (
        (evaluate_matrix(predators, prey) < 1000).mean()
        for predators in (first['predators'], last['predators'])
    )
    assert before < 0.35
    assert after > before + 0.25


def test_help_states_units_and_defaults(start):
    run = start(['coevo_manager', 'evolve', '--help'], {'COLUMNS': '300'})
    assert run.wait() == 0
    for name, field in all_fields().items():
        option = f'--{name.replace("_", "-")} '
        (line,) = [x for x in run.stdout_text.split('\n  --') if f'--{x}'.startswith(option)]
        assert field.unit in line
        if field.default is not None:
            assert f'default: {field.default}' in line


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        (['--population', '80', '--selected', '12'], 'power of two'),
        (['--population', 'many'], "evolve: population is 'many', expected a whole number from 2"),
        (['--mutation-rate', '1.5'], 'mutation_rate is 1.5, expected a number from 0 to 1'),
        (['--algorithm', 'best'], "algorithm is 'best', expected one of archive, "),
        (['--preset', 'slow'], 'invalid choice'),
        (['--generation', '5'], 'unrecognized arguments: --generation 5'),
        (['--evaluators', '-1'], 'evaluators is -1, expected a whole number from 0'),
        (['--resume', 'nowhere'], 'holds no run'),
        (['--resume', 'nowhere', '--out', 'x'], 'out is given, expected none with --resume'),
        (['--config', 'missing.yaml'], 'missing.yaml cannot be read: No such file'),
        (['--config', 'unknown.yaml'], 'configuration key populaton is unknown'),
        (['--config', 'list.yaml'], 'list.yaml is no mapping, expected'),
        (['--ros-args', '-r', 'nothing'], "remap rule: '-r nothing'"),
        (['--out', 'occupied'], 'occupied is not empty'),
        (['--out', 'list.yaml/run'], 'list.yaml is not a folder'),
    ],
)
def test_bad_options_are_refused_in_one_sentence(tmp_path, monkeypatch, capsys, options, sentence):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'unknown.yaml').write_text('{populaton: 3}')
    (tmp_path / 'list.yaml').write_text('[1, 2]')
    (tmp_path / 'occupied').mkdir()
    (tmp_path / 'occupied' / 'thesis.tex').touch()
    before = sorted(tmp_path.rglob('*'))
    with pytest.raises(SystemExit) as exit_code:
        sys.exit(evolve.main(options))
    assert exit_code.value.code == 2
    errors = capsys.readouterr().err
    assert sentence in errors
    assert errors.count('\n') == 1
    assert sorted(tmp_path.rglob('*')) == before


def test_no_evaluator_answers(start, tmp_path):
    run = start(['coevo_manager', 'evolve', '--evaluators', '--out', tmp_path / 'k'])
    assert run.wait() == 2
    assert 'no evaluator answered within 10 s' in run.stderr_text
    assert not (tmp_path / 'k').exists()


def test_evaluators_that_cannot_be_started_are_told_in_one_sentence(start, tmp_path):
    few_files = ['bash', '-c', 'ulimit -n 20; exec "$@"', 'bash']
    evolve = executable_path('coevo_manager', 'evolve')
    run = start([*few_files, evolve, '--preset', 'quick', '--out', tmp_path / 'run'])
    assert run.wait() == 2
    (line,) = run.stderr_text.splitlines()
    assert line.startswith('evolve: an evaluator cannot be started: [Errno 24]')
    assert not (tmp_path / 'run').exists()


def test_a_configuration_file_is_the_base_of_the_options(tmp_path):
    path = tmp_path / 'run.yaml'
    path.write_text('{population: 32, selected: 8, predator_speed: 9.0, phases: 7}')
    options = read_options(['--config', str(path), '--phases', 'none', '--ticks', '9000000'])
    plan = make_plan(options.values, 'paper', tmp_path / 'new', None)
    assert plan.configuration.population == 32
    assert plan.configuration.predator_speed == 9.0
    assert plan.configuration.phases is None
    assert plan.configuration.generations == 100


def test_resuming_with_another_configuration_names_the_difference(start, tmp_path, toy):
    folder = tmp_path / 'l'
    folder.mkdir()
    (folder / 'run.json').write_bytes(toy['run.json'])
    run = start(['coevo_manager', 'evolve', '--resume', folder, '--seed', '5'])
    assert run.wait() == 2
    assert 'seed: 1, 5' in run.stderr_text


def in_folder(folder, command):
    return ['/usr/bin/env', '-C', folder, 'bash', '-c', command]


def test_two_started_at_once_get_a_folder_each(start, tmp_path):
    options = ' '.join([*TOY, '--phases', '2', '--evaluators', '1'])
    command = in_folder(tmp_path, f'exec {executable_path("coevo_manager", "evolve")} {options}')
    both = [start(command) for _ in range(2)]
    assert [run.wait() for run in both] == [0, 0], [run.stderr_text for run in both]
    folders = [tmp_path / 'runs' / f'standard-1-{number}' for number in (1, 2)]
    assert sorted((tmp_path / 'runs').iterdir()) == folders
    assert read_files(folders[0]) == read_files(folders[1])


def test_a_run_that_does_not_begin_leaves_no_folder(start, tmp_path):
    run = start(in_folder(tmp_path, f'exec {executable_path("coevo_manager", "evolve")}'))
    wait_until(lambda: list(tmp_path.glob('runs/*')), 'the folder of the run')
    run.send_signal(signal.SIGINT)
    assert run.wait() == 130
    assert list(tmp_path.glob('runs/*')) == []


def test_a_reader_that_goes_away_ends_the_display_alone(start, tmp_path):
    options = ' '.join([*TOY, '--evaluators', '1', '--out', str(tmp_path / 'm')])
    evolve_command = f'{executable_path("coevo_manager", "evolve")} {options}'
    run = start(in_folder(tmp_path, f'{evolve_command} | head -n 1; exit ${{PIPESTATUS[0]}}'))
    assert run.wait() == 0, run.stderr_text
    assert run.stdout_text.count('\n') == 1
    assert run.stderr_text == ''
    assert (tmp_path / 'm' / 'report.md').exists()

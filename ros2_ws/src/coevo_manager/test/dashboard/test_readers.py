"""What the dashboard reads of run folders: states, logs that grow, links that lead away."""

import datetime
import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import psutil
import pytest
from analysis_runs import TINY, make_run

from coevo_manager.analysis.logs import read_columns
from coevo_manager.core.episodes import evaluate_matrix, measure_pairs
from coevo_manager.core.evolution.run_folder import LOGS
from coevo_manager.core.evolution.sessions import Session, read_sessions
from coevo_manager.dashboard import charts, plays
from coevo_manager.dashboard.growing import GrowingLog, last_events
from coevo_manager.dashboard.library import Library, run_folders
from coevo_manager.dashboard.plays import Plays
from coevo_manager.dashboard.watched import WatchedRun
from neuro_controller.core.reading import ReadingError


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp('runs') / 'run')


@pytest.fixture
def folder(made, tmp_path):
    """A copy of a finished run, to be changed."""
    return shutil.copytree(made, tmp_path / 'run')


def table(path, log):
    return pd.DataFrame(read_columns(path, LOGS[log]))


def watched(folder):
    return WatchedRun('key', 'mine', folder)


def set_session(folder, **values):
    path = folder / 'sessions.json'
    path.write_text(json.dumps([json.loads(path.read_text())[0] | values]))


def set_status(folder, **values):
    (folder / 'status.json').write_text(json.dumps(values))


def test_a_finished_run_tells_what_it_was(made):
    seen = watched(made).look()
    phases = table(made / 'phases.csv', 'phases')
    assert (seen['state'], seen['progress'], seen['problem']) == ('finished', 1.0, '')
    assert (seen['phase'], seen['generation']) == (4, 40)
    assert seen['predator_fitness'] == phases['predator_fitness'].iloc[-1]
    assert seen['episodes'] == phases['episodes'].iloc[-1]
    assert seen['configuration']['population'] == TINY['population']
    assert seen['snapshots'] == [0, 10, 20, 30, 40]
    (session,) = read_sessions(made)
    rate = phases['ticks'].iloc[-1] / max(session['seconds'], 0.1)
    assert seen['ticks_per_second'] == pytest.approx(rate)
    assert seen['events'][-1].endswith(' finished')


@pytest.mark.parametrize('ended', ['stopped', 'failed'])
def test_an_ended_run_says_how(folder, ended):
    set_session(folder, ended=ended)
    assert watched(folder).look()['state'] == ended


def test_a_run_whose_process_is_gone_was_killed(folder):
    child = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=subprocess.PIPE)
    begun = datetime.datetime.now().astimezone().isoformat()
    set_session(folder, ended=None, process=child.pid, begun=begun)
    run = watched(folder)
    assert run.look()['state'] == 'running'
    child.kill()
    while psutil.Process(child.pid).status() != psutil.STATUS_ZOMBIE:
        pass
    assert run.look()['state'] == 'killed'
    child.wait()
    assert run.look()['state'] == 'killed'


def test_another_process_of_the_same_number_is_not_the_run(folder):
    set_session(folder, ended=None, process=os.getpid(), begun='2001-01-01T00:00:00+00:00')
    assert watched(folder).look()['state'] == 'killed'


def test_a_run_elsewhere_goes_on_while_it_writes(folder):
    set_session(folder, ended=None, host='another')
    assert watched(folder).look()['state'] == 'running'
    for path in folder.iterdir():
        os.utime(path, (10**9, 10**9))
    assert watched(folder).look()['state'] == 'silent'


def test_the_status_leads_and_the_logs_stand_in(folder):
    Session(folder, 4)
    run = watched(folder)
    assert run.look()['seconds_left'] is None
    set_status(folder, generation=55, phase=6, seconds_left=12.5, evaluators=[{'service': '/a'}])
    seen = run.look()
    assert (seen['generation'], seen['seconds_left']) == (55, 12.5)
    assert seen['evaluators'] == [{'service': '/a'}]
    set_status(folder, generation=7, phase=1, seconds_left=99)
    seen = run.look()
    assert (seen['generation'], seen['phase'], seen['seconds_left']) == (40, 4, 99)


def test_a_status_that_makes_no_sense_is_not_passed_on(folder):
    Session(folder, 4)
    values = {'generation': 'many', 'progress': 1e400, 'evaluators': 'none', 'losses': [3]}
    set_status(folder, **values)
    (folder / 'status.json').write_text('{"generation": "x", "progress": 1e999, "losses": [3]}')
    seen = watched(folder).look()
    assert (seen['generation'], seen['evaluators'], seen['losses']) == (40, None, [])
    json.dumps(seen, allow_nan=False)


def test_a_log_is_read_on_where_it_was_left(made, tmp_path):
    content = (made / 'generations.csv').read_bytes()
    path = tmp_path / 'generations.csv'
    log = GrowingLog(path, LOGS['generations'])
    assert not log.grow()
    for end in (10, 300, 301, len(content)):
        path.write_bytes(content[:end])
        log.grow()
        assert len(log.table) == max(content[:end].count(b'\n') - 1, 0)
    whole = table(path, 'generations')
    assert log.table.equals(whole)
    lines = content.splitlines(keepends=True)
    path.write_bytes(b''.join(lines[:11]))
    assert log.grow()
    assert log.table.equals(whole[:10])
    path.write_bytes(b''.join(lines[:11]) + b'11,2,prey,7,0,1,0,99,99\n')
    with pytest.raises(ReadingError, match='line 12, fitness_mean is 7'):
        log.grow()


def test_events_leave_completed_phases_out(tmp_path):
    lines = [f'2026 completed phase {k}, generation {k}' for k in range(500)]
    (tmp_path / 'run.log').write_text('\n'.join(['2026 started', *lines, '2026 joined', 'half']))
    assert last_events(tmp_path / 'run.log', 5) == ['2026 joined']


def test_no_link_leads_outside(folder, tmp_path):
    secret = tmp_path / 'secret'
    secret.write_text('2026 password\n')
    (folder / 'run.log').unlink()
    (folder / 'run.log').symlink_to(secret)
    seen = watched(folder).look()
    assert 'run.log is a symbolic link' in seen['problem']
    assert 'password' not in json.dumps(seen)
    (tmp_path / 'watched').mkdir()
    (tmp_path / 'watched' / 'link').symlink_to(folder)
    assert list(run_folders(tmp_path / 'watched')) == []
    shutil.move(folder / 'snapshots', tmp_path / 'elsewhere')
    (folder / 'snapshots').symlink_to(tmp_path / 'elsewhere')
    with pytest.raises(ReadingError):
        watched(folder).snapshot('40')


def test_runs_are_found_under_folders_and_forgotten_when_they_go(made, tmp_path, monkeypatch):
    for name in ('a/b/one', 'two', 'a/.hidden/three', '1/2/3/4/5/deep'):
        shutil.copytree(made, tmp_path / name)
    monkeypatch.setattr('coevo_manager.dashboard.library.FIND_PERIOD', 0)
    monkeypatch.setattr('coevo_manager.dashboard.library.LOOK_PERIOD', 0)
    library = Library([tmp_path, tmp_path / 'two'])
    assert {run['name'] for run in library.look().values()} == {'a/b/one', 'two'}
    assert library.problems == []
    (tmp_path / 'broken').mkdir()
    (tmp_path / 'broken' / 'run.json').write_text('{"version": 1, "configuration": 3}')
    assert {run['name'] for run in library.look().values()} == {'a/b/one', 'two'}
    (problem,) = library.problems
    assert 'configuration is 3' in problem
    shutil.rmtree(tmp_path / 'a')
    assert [run['name'] for run in library.look().values()] == ['two']


def test_an_episode_is_that_of_the_individuals(made):
    run = watched(made)
    run.look()
    last, first = run.snapshot('40'), run.snapshot('0')
    found = Plays().episode(run, ('40', 'best'), ('0', 'worst'))
    predators = last.predators[last.ranking('predator')[:1]]
    prey = first.prey[first.ranking('prey')[-1:]]
    assert found['ticks'] == evaluate_matrix(predators, prey, run.environment)[0, 0]
    now = run.snapshot('now')
    assert now.generation == 40
    np.testing.assert_array_equal(now.predators, last.predators)
    np.testing.assert_allclose(now.fitness, last.fitness, atol=1e-6)
    for wrong in (('41', 'best'), ('40', 'champion'), ('../40', 'best')):
        with pytest.raises(ReadingError):
            Plays().episode(run, wrong, ('0', 'best'))


def test_the_small_tournament_is_played_bit_by_bit(made, monkeypatch):
    run = watched(made)
    run.look()
    played = Plays()
    monkeypatch.setattr(plays, 'PATIENCE', 0)
    assert played.tournament(run)['missing'] == 25
    monkeypatch.setattr(plays, 'PATIENCE', 60)
    found = played.tournament(run)
    assert found['missing'] == 0
    heat, complexity = found['chart']['panels']
    predators = run.snapshot('30').best('predator', plays.BEST)
    prey = run.snapshot('10').best('prey', plays.BEST)
    expected = 1 - evaluate_matrix(predators, prey, run.environment).mean() / 150
    assert heat['data'][0]['z'][3][1] == pytest.approx(expected, rel=1e-3, abs=1e-4)
    own = run.snapshot('30').best('prey', plays.BEST)
    index = np.indices((plays.BEST, plays.BEST)).reshape(2, -1)
    _, both = measure_pairs(predators, own, *index, run.environment)
    for line, mean in zip(complexity['data'], both.mean(axis=0), strict=True):
        assert line['y'][3] == pytest.approx(mean, rel=1e-3)


def test_runs_are_told_apart_by_a_field(made, folder, tmp_path):
    other = make_run(tmp_path / 'other', algorithm='simplified')
    runs = [watched(each) for each in (made, folder, other)]
    for run in runs:
        run.look()
    chart = charts.run_charts(runs, 'algorithm')
    names = [entry['name'] for entry in chart['legend']]
    assert names == ['algorithm standard, mean of 2', 'algorithm simplified']
    same, equal, mean, _ = chart['panels'][1]['data']
    assert same['y'] == equal['y']
    phases = runs[0].phases.table
    expected = np.interp(mean['x'][0], phases['generation'], phases['predator_fitness'])
    assert mean['y'][0] == pytest.approx(expected, rel=1e-3)
    alone = charts.run_charts(runs[:1], 'run')
    retained, accepted = alone['panels'][2:]
    np.testing.assert_allclose(retained['data'][0]['y'], phases['retained'][1:])
    table = runs[0].generations.table
    np.testing.assert_allclose(accepted['data'][0]['y'], table['accepted'] / 2)


def test_long_curves_are_means_of_neighbours():
    x = np.arange(4000.0)
    thin_x, thin_y = charts.thinned(x, np.where(x < 2000, 0.0, 1.0))
    assert len(thin_x) == charts.POINTS
    assert thin_x[0] == 4.5
    assert thin_y.mean() == 0.5 and set(thin_y) == {0.0, 1.0}

"""Campaigns: what they refuse, and runs that end, fail, are killed and continue."""

import os
import signal
import threading
import time

import pandas as pd
import pytest
import yaml
from analysis_runs import TINY, make_run
from distributed import Client
from distributed.security import Security
from evolve_runs import phases_completed, read_files

from coevo_manager import cluster
from coevo_manager.cluster import ClusterError, connect, own_cluster
from coevo_manager.runs import campaign
from coevo_manager.runs.jobs import CampaignError, execute, read_campaign


def write(path, **content):
    path.write_text(
        yaml.safe_dump({'out': 'runs', 'seeds': [1], 'configuration': TINY, **content})
    )
    return path


@pytest.fixture
def client():
    with own_cluster(2) as connected:
        yield connected


def test_conditions_environments_and_seeds(tmp_path):
    path = write(
        tmp_path / 'c.yaml',
        conditions={'plain': {'algorithm': 'vanilla', 'selected': 8}, 'standard': {}},
        environments=['open', 'obstacle'],
        seeds=[1, 2, 5],
    )
    jobs = read_campaign(path).jobs
    assert len(jobs) == 2 * 2 * 3
    assert jobs[0].folder == tmp_path / 'runs' / 'plain-open-seed1'
    assert jobs[-1].configuration.environment == 'obstacle'
    assert jobs[-1].configuration.seed == 5
    assert {job.configuration.algorithm for job in jobs} == {'vanilla', 'standard'}


def test_a_condition_may_have_seeds_of_its_own(tmp_path):
    conditions = {'standard': {}, 'simplified': {'algorithm': 'simplified', 'seeds': [7, 8]}}
    path = write(tmp_path / 'c.yaml', conditions=conditions, seeds=[1, 2, 3])
    assert {job.folder.name for job in read_campaign(path).jobs} == {
        *(f'standard-open-seed{seed}' for seed in (1, 2, 3)),
        *(f'simplified-open-seed{seed}' for seed in (7, 8)),
    }


def test_without_environments_each_run_has_that_of_its_configuration(tmp_path):
    path = write(
        tmp_path / 'c.yaml',
        configuration={'environment': 'obstacle'},
        conditions={'standard': {}, 'free': {'environment': 'open'}},
        seeds=[1],
    )
    found = {job.folder.name: job.configuration.environment for job in read_campaign(path).jobs}
    assert found == {'standard-obstacle-seed1': 'obstacle', 'free-open-seed1': 'open'}


@pytest.mark.parametrize(
    ('content', 'expected'),
    [
        ({'conditions': {'a': {'seeds': 3}}}, 'conditions.a.seeds is 3'),
        ({'conditions': {'a': {'seed': 3}}}, 'conditions.a.seed: seeds belong into seeds'),
        (
            {'conditions': {'a': {'environment': 'obstacle'}}, 'environments': ['open']},
            "conditions.a sets environment to 'obstacle' and environments.open to 'open'",
        ),
        ({'environments': {'a': {'seeds': [3]}}}, "environments.a: 'seeds' is unknown"),
        ({'speed': 1}, "key 'speed' is unknown"),
        ({'seeds': []}, 'seeds is []'),
        ({'seeds': [1, 1]}, 'seeds is [1, 1]'),
        ({'seeds': ['x']}, "seed is 'x', expected a whole number"),
        ({'retries': -1}, 'retries is -1'),
        ({'out': 3}, 'out is 3'),
        ({'out': ''}, "out is '', expected a folder"),
        ({'conditions': {'fast': {'sped': 1}}}, "conditions.fast: 'sped' is unknown"),
        ({'conditions': ['magic']}, "algorithm is 'magic', expected one of"),
        ({'conditions': {'a/b': {}}}, "conditions has the name 'a/b'"),
        ({'environments': []}, 'environments is empty'),
        ({'configuration': {'population': 1}}, 'population is 1, expected'),
        ({'configuration': {'seed': 1}}, 'seeds belong into seeds'),
        ({'preset': 'huge'}, "preset is 'huge', expected one of"),
    ],
)
def test_bad_files(tmp_path, capsys, content, expected):
    path = write(tmp_path / 'c.yaml', **content)
    assert campaign.main([str(path)]) == 2
    error = capsys.readouterr().err.strip()
    assert expected in error
    assert '\n' not in error
    assert not (tmp_path / 'runs').exists()


def test_no_file_and_no_yaml(tmp_path, capsys):
    assert campaign.main([str(tmp_path / 'none.yaml')]) == 2
    (tmp_path / 'c.yaml').write_text('a: [')
    assert campaign.main([str(tmp_path / 'c.yaml')]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 2


@pytest.mark.parametrize(
    'content',
    [
        b'out: "runs\\0"\nseeds: [1]',
        b'out: runs\nseeds: [1]\nconditions: {' + b'x' * 300 + b': {}}',
        b'out: runs\nseeds: [1]\nconditions: {"a\\nb": {}}',
        b'out: runs\nseeds: [' + b', '.join(b'%d' % k for k in range(9000)) + b']\n'
        b'conditions: {a: {}, b: {}}',
        b'out: runs\nseeds: [1]\nretries: [[[[[[[[[[1]]]]]]]]]]',
        b'out: &a [x, *a]\nseeds: [1]',
        b'out: r\xe9sultats\nseeds: [1]',
        b'[' * 100_000,
    ],
)
def test_hostile_files(tmp_path, capsys, content):
    path = tmp_path / 'c.yaml'
    path.write_bytes(content)
    assert campaign.main([str(path)]) == 2
    error = capsys.readouterr().err.strip()
    assert '\n' not in error
    assert str(path) in error
    assert len(error) < 400
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ('address', 'sentence'),
    [
        ('nowhere', 'expected the address of a scheduler such as tls://HOST:8786'),
        ('http://localhost:80', 'expected the address'),
        ('tcp://localhost:99999', 'expected the address'),
        ('tcp://localhost:1', 'no scheduler answers there'),
        ('tls://localhost:1', 'Dask is configured with none'),
    ],
)
def test_a_wrong_address_is_a_sentence(tmp_path, capsys, monkeypatch, address, sentence):
    monkeypatch.setattr(cluster, 'TIMEOUT', 1)
    assert campaign.main([str(write(tmp_path / 'c.yaml')), '--dask', address]) == 2
    error = capsys.readouterr().err.strip()
    assert 'dask is ' in error
    assert address in error
    assert sentence in error
    assert '\n' not in error


def test_who_has_no_credentials_leaves_no_client_half_made():
    threads = threading.active_count()
    with pytest.raises(ClusterError, match='need credentials'):
        connect('tls://localhost:1')
    assert threading.active_count() == threads


def test_strangers_cannot_use_its_cluster(client):
    """Neither without credentials nor with others: any user of the machine could connect."""
    address = client.scheduler.address
    assert address.startswith('tls://')
    for stranger, security in (
        (address.replace('tls', 'tcp'), None),
        (address, Security.temporary()),
    ):
        with pytest.raises(OSError):
            Client(stranger, security=security, timeout=5)


def test_another_run_in_the_folder(tmp_path):
    path = write(tmp_path / 'c.yaml')
    make_run(tmp_path / 'runs' / 'standard-open-seed1', seed=1, mutation_rate=0.1)
    with pytest.raises(CampaignError, match=r'mutation_rate: 0\.1, 0\.02'):
        read_campaign(path)


def test_runs_finish_fail_and_are_skipped(tmp_path, client):
    path = write(tmp_path / 'c.yaml', seeds=[1, 2, 3])
    blocked = tmp_path / 'runs' / 'standard-open-seed2'
    blocked.mkdir(parents=True)
    (blocked / 'in the way').touch()
    told = {}
    table = execute(
        read_campaign(path), client, lambda job, error: told.update({job.folder: error})
    )
    states = dict(zip(table['seed'], table['state'], strict=True))
    assert states == {1: 'finished', 2: 'failed', 3: 'finished'}
    assert 'is not empty' in told[blocked]
    alone = make_run(tmp_path / 'alone', 'standard', seed=1)
    assert read_files(tmp_path / 'runs' / 'standard-open-seed1') == read_files(alone)
    assert list(pd.read_csv(tmp_path / 'runs' / 'campaign.csv')['state']) == list(table['state'])

    (blocked / 'in the way').unlink()
    before = (tmp_path / 'runs' / 'standard-open-seed1' / 'run.log').read_bytes()
    table = execute(read_campaign(path), client)
    assert set(table['state']) == {'finished'}
    assert (tmp_path / 'runs' / 'standard-open-seed1' / 'run.log').read_bytes() == before


def test_a_killed_worker_costs_no_result(tmp_path, client):
    """Its run continues from the last checkpoint on another worker, to the same files."""
    values = {'phases': 60, 'generations': 20, 'swap_generations': 100, 'episode_ticks': 400}
    path = write(tmp_path / 'c.yaml', configuration={**TINY, **values})
    planned = read_campaign(path)
    folder = planned.jobs[0].folder
    found = {}
    running = threading.Thread(target=lambda: found.update(table=execute(planned, client)))
    running.start()
    deadline = time.monotonic() + 60
    while phases_completed(folder) < 3 and time.monotonic() < deadline:
        time.sleep(0.01)
    busy = client.run(lambda dask_worker: (os.getpid(), len(dask_worker.state.executing)))
    victims = [pid for pid, executing in busy.values() if executing]
    assert len(victims) == 1
    os.kill(victims[0], signal.SIGKILL)
    completed = phases_completed(folder)
    running.join(timeout=90)
    assert not running.is_alive()
    assert completed < 60  # it was killed before its end
    assert list(found['table']['state']) == ['finished']
    assert 'resumed after phase' in (folder / 'run.log').read_text()
    alone = make_run(tmp_path / 'alone', 'standard', seed=1, **values)
    assert read_files(folder) == read_files(alone)

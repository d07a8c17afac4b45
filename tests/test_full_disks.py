"""Commands on a full disk: one sentence that names the file, exit code 1, nothing half-written."""

import pandas as pd
import pytest
import yaml
from analysis_runs import TINY, make_run
from full_disk import full_disk

from coevo_manager import export
from coevo_manager.analysis import command as analyze
from coevo_manager.analysis.transfer import command as transfer
from coevo_manager.runs import campaign


@pytest.fixture(scope='module')
def run(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp('full') / 'run')


def check(capsys, command, arguments, size):
    with full_disk(size):
        assert command.main([str(argument) for argument in arguments]) == 1
    return capsys.readouterr().err


def last_line(errors):
    return errors.strip().splitlines()[-1]


def files(folder):
    return {path for path in folder.rglob('*') if path.is_file()}


@pytest.mark.parametrize('size', [200, 30_000])
def test_analyze(run, tmp_path, capsys, size):
    out = tmp_path / 'out'
    arguments = (run, '--out', out, '--probe', 0, '--every', 40, '--threads', 1)
    sentence = last_line(check(capsys, analyze, arguments, size))
    assert sentence.startswith(f'analyze: {out}/') and sentence.endswith(': File too large')
    assert all(path.stat().st_size < size for path in files(out))
    for path in out.rglob('*.csv'):
        assert len(pd.read_csv(path))


def test_transfer(run, tmp_path, capsys):
    out = tmp_path / 'out'
    arguments = (run, '--out', out, '--champions', 1, '--draws', 1)
    sentence = last_line(check(capsys, transfer, arguments, 500))
    assert sentence == f'transfer: {out}/transfer.csv: File too large'
    assert not files(out)


@pytest.mark.parametrize('format', ['yaml', 'header'])
def test_export(run, tmp_path, capsys, format):
    path = tmp_path / 'robot.file'
    arguments = (run, '--species', 'prey', f'--{format}', path)
    sentence = last_line(check(capsys, export, arguments, 3000))
    assert sentence == f'export: {path}: File too large'
    assert not files(tmp_path)


def test_campaign(tmp_path, capsys):
    path = tmp_path / 'campaign.yaml'
    path.write_text(
        yaml.safe_dump({'out': 'runs', 'seeds': [1], 'retries': 0, 'configuration': TINY})
    )
    errors = ' '.join(check(capsys, campaign, [path], 20_000).split())
    assert 'standard-open-seed1: RunFolderError: cannot write' in errors
    assert 'File too large' in errors
    assert not list(tmp_path.rglob('*.partial'))
    assert campaign.main([str(path)]) == 0
    assert (tmp_path / 'runs' / 'standard-open-seed1' / 'report.md').exists()

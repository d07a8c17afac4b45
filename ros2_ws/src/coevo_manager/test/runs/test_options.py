"""The command line of evolve: files, templates and worlds."""

import os
import re
import subprocess
import sys

import pytest
import yaml
from analysis_runs import make_run

from coevo_manager.core.evolution import load_configuration, read_configuration
from coevo_manager.runs import evolve
from coevo_manager.runs.options import read_options
from coevo_manager.runs.template import make_template

GIVEN = {'algorithm': 'hall_of_fame', 'seed': 7, 'prey_speed': 9.5, 'phases': None, 'ticks': 10**9}


@pytest.mark.parametrize('preset', ['quick', 'paper'])
def test_a_template_gives_the_configuration_back(preset):
    template = make_template(GIVEN, preset)
    assert yaml.safe_load(template) == GIVEN
    all_given = re.sub(r'^#(?=\w+:)', '', template, flags=re.MULTILINE)
    assert load_configuration(yaml.safe_load(all_given)) == load_configuration(GIVEN, preset)
    assert all(len(line) <= 99 for line in template.splitlines())


def test_evolve_prints_a_template_and_runs_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert evolve.main(['--print-config', '--preset', 'paper', '--population', '40']) == 0
    assert yaml.safe_load(capsys.readouterr().out) == {'population': 40}
    assert not list(tmp_path.iterdir())


def test_a_runs_own_file_repeats_it(tmp_path):
    run = make_run(tmp_path / 'run', seed=3, world='robust', camera_noise=0.1)
    options = read_options(['--config', str(run / 'run.json')])
    assert load_configuration(options.values) == read_configuration(run)
    other = read_options(['--config', str(run / 'run.json'), '--seed', '4']).values
    assert load_configuration(other) == load_configuration(options.values | {'seed': 4})


def test_a_world_given_as_an_option_goes_before_the_files_settings(tmp_path):
    run = make_run(tmp_path / 'run', world='robust', prey_speed=9.0)
    values = read_options(['--config', str(run / 'run.json'), '--world', 'faithful']).values
    environment = load_configuration(values).make_environment()
    expected = load_configuration({'world': 'faithful', 'prey_speed': 9.0, 'episode_ticks': 150})
    assert environment == expected.make_environment()


@pytest.mark.parametrize('command', ['analysis.command', 'analysis.transfer.command'])
def test_a_command_uses_the_cores_that_it_is_given(command):
    code = (
        f'from coevo_manager.{command} import make_parser\n'
        'print(make_parser().get_default("threads"))'
    )
    one = {min(os.sched_getaffinity(0))}
    found = subprocess.run(
        [sys.executable, '-c', code],
        preexec_fn=lambda: os.sched_setaffinity(0, one),
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout == '1\n'

"""Algorithms and optimizers of other packages, found through their entry points."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ALGORITHM = '''
from coevo_manager.core.evolution.algorithms.simplified import Simplified
from marxbot_sim.core.fields import Option


class Favourites(Simplified):
    """A package's own."""

    parameters = (Option('favourites', int, 3, 'how many there are', 'genomes', 1, 9),)
'''

RUN = """
import json, sys
from pathlib import Path
from coevo_manager.core.evolution import Evolution, load_configuration
from coevo_manager.core.local_evaluator import LocalEvaluator

values = json.loads(sys.argv[1])
configuration = load_configuration(values)
folder = Path(sys.argv[2])
Evolution(configuration, LocalEvaluator(configuration.make_environment()), folder).run()
print(json.loads((folder / 'run.json').read_text())['configuration'])
"""


@pytest.fixture
def package(tmp_path):
    """Put a distribution where Python finds it, as installing it would; return its folder."""
    (tmp_path / 'others.py').write_text(ALGORITHM)
    metadata = tmp_path / 'others-1.0.dist-info'
    metadata.mkdir()
    (metadata / 'METADATA').write_text('Metadata-Version: 2.1\nName: others\nVersion: 1.0\n')
    (metadata / 'entry_points.txt').write_text(
        '[coevo_manager.algorithms]\nfavourites = others:Favourites\nbroken = others:Missing\n'
    )
    return tmp_path


def python(package, code, *arguments):
    path = os.pathsep.join([str(package), *(p for p in sys.path if p)])
    return subprocess.run(
        [sys.executable, '-c', code, *arguments],
        env={**os.environ, 'PYTHONPATH': path},
        capture_output=True,
        text=True,
        timeout=120,
        cwd=package,
    )


def declare(package, line):
    path = package / 'others-1.0.dist-info' / 'entry_points.txt'
    path.write_text(f'[coevo_manager.algorithms]\n{line}\n')


def test_an_installed_algorithm_runs_with_its_own_fields(package):
    declare(package, 'favourites = others:Favourites')
    values = (
        '{"algorithm": "favourites", "favourites": 5, "population": 8, "phases": 1, '
        '"generations": 2, "episode_ticks": 20}'
    )
    ended = python(package, RUN, values, str(Path(package) / 'run'))
    assert ended.returncode == 0, ended.stderr
    assert "'favourites': 5" in ended.stdout
    helped = python(
        package,
        "import sys; sys.argv = ['evolve', '--help']\n"
        'from coevo_manager.runs.options import read_options; read_options(sys.argv[1:])',
    )
    text = ' '.join(helped.stdout.split())
    assert (
        '--favourites NUMBER algorithm favourites: how many there are (genomes; default: 3)'
        in text
    )
    refused = python(
        package,
        'from coevo_manager.core.evolution import load_configuration as f\n'
        "f({'algorithm': 'favourites', 'favourites': 10})",
    )
    assert 'favourites is 10, expected a whole number from 1 to 9 (genomes)' in refused.stderr


@pytest.mark.parametrize(
    ('line', 'sentence'),
    [
        ('broken = others:Missing', 'algorithm broken cannot be loaded from others:Missing'),
        ('broken = others:Option', 'algorithm broken is others:Option, expected a subclass'),
    ],
)
def test_what_cannot_be_loaded_is_named(package, line, sentence):
    declare(package, line)
    code = 'from coevo_manager.core.evolution import load_configuration as f; f({})'
    assert sentence in python(package, code).stderr


def test_a_field_has_one_owner(package):
    others = package / 'others.py'
    others.write_text(others.read_text().replace("'favourites'", "'archive_share'"))
    declare(package, 'favourites = others:Favourites')
    code = 'from coevo_manager.core.evolution import load_configuration as f; f({})'
    assert 'its name, archive_share, is taken' in python(package, code).stderr

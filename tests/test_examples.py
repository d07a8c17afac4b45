"""The scripts of examples/, as a reader runs them."""

import subprocess
import sys

import pytest
from ros_processes import ROOT

FOREIGN = {'train_ppo.py'}
"""What needs libraries that are no dependencies."""

EXAMPLES = sorted(ROOT.glob('examples/*.py'))


def test_every_example_is_listed():
    page = (ROOT / 'examples' / 'README.md').read_text()
    assert [path.name for path in EXAMPLES if f'({path.name})' not in page] == []


@pytest.mark.parametrize(
    'path', [path for path in EXAMPLES if path.name not in FOREIGN], ids=lambda path: path.stem
)
def test_example_runs(path, tmp_path):
    result = subprocess.run(
        [sys.executable, path], cwd=tmp_path, capture_output=True, text=True, timeout=240
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout


@pytest.mark.parametrize('path', EXAMPLES, ids=lambda path: path.stem)
def test_example_compiles(path):
    compile(path.read_text(), path, 'exec')

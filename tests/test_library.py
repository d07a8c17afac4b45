"""The library: from a wheel in an environment of its own, and wherever else it works."""

import doctest
import os
import shutil
import subprocess
import sys
import sysconfig
from importlib import metadata
from pathlib import Path

import pytest
from ros_processes import ROOT

import red_queen as rq
from red_queen import environments

SOURCES = ROOT / 'ros2_ws' / 'src'
SITE = Path(sysconfig.get_path('purelib'))

NOTEBOOK = """
import sys
import numpy as np
import red_queen as rq

settings = dict(population=8, selected=2, generations=5, phases=2, snapshot_generations=10)
assert rq.evolve('runs/mine', threads=1, **settings).finished
run = rq.read_run('runs/mine')
last = run.snapshot(max(run.snapshots))
assert run.columns('phases')['generation'].tolist() == [0, 5, 10]
ticks = rq.evaluate_matrix(last.predators, last.prey, run.environment)
assert np.allclose(rq.fitness(ticks, 'predator'), last.fitness, atol=1e-6)
champions = [rq.select_champion('runs/mine', species).genome for species in rq.SPECIES]
trace = rq.trace_pair(*champions, run.environment)
assert trace.ticks == rq.evaluate_matrix(champions[:1], champions[1:], run.environment)[0, 0]
assert rq.select_champion('shipped/open', 'prey').genome.shape == (442,)
assert 'matplotlib' not in sys.modules and 'pandas' not in sys.modules
print(rq.__file__)
"""


def run(*arguments, cwd):
    return subprocess.run(
        [str(argument) for argument in arguments],
        cwd=cwd,
        env={'PATH': '/usr/bin:/bin', 'HOME': str(cwd)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
    )


@pytest.fixture(scope='module')
def wheel(tmp_path_factory):
    """Build the wheel from a copy of what it is made of, without a network."""
    source = tmp_path_factory.mktemp('source')
    for name in ('pyproject.toml', 'README.md', 'LICENSE'):
        shutil.copy(ROOT / name, source)
    shutil.copytree(
        SOURCES,
        source / 'ros2_ws' / 'src',
        ignore=shutil.ignore_patterns('test', '__pycache__', 'setup.py'),
    )
    build = [sys.executable, '-m', 'pip', 'wheel', '--no-deps', '--no-build-isolation', '.']
    result = run(*build, '--wheel-dir', source / 'wheels', cwd=source)
    assert result.returncode == 0, result.stderr
    (path,) = (source / 'wheels').iterdir()
    return path


@pytest.fixture(scope='module')
def plain(wheel, tmp_path_factory):
    """Make an environment of the wheel, NumPy and Numba alone."""
    folder = tmp_path_factory.mktemp('plain')
    result = run(sys.executable, '-m', 'venv', '--without-pip', folder / 'venv', cwd=folder)
    assert result.returncode == 0, result.stderr
    python = folder / 'venv' / 'bin' / 'python'
    ask = 'import sysconfig; print(sysconfig.get_path("purelib"))'
    site = Path(run(python, '-c', ask, cwd=folder).stdout.strip())
    for name in ('numpy', 'numba', 'llvmlite'):
        for top in {Path(str(file)).parts[0] for file in metadata.files(name)} - {'..'}:
            whole = SITE / top
            if whole.is_dir():
                shutil.copytree(whole, site / top, copy_function=os.link, dirs_exist_ok=True)
    install = [SITE.parents[2] / 'bin' / 'uv', 'pip', 'install', '--offline', '--python', python]
    result = run(*install, wheel, cwd=folder)
    assert result.returncode == 0, result.stderr
    for compiled in SOURCES.rglob('*.nb[ci]'):  # kernels of these very sources, to save time
        place = site / compiled.relative_to(SOURCES).relative_to(
            compiled.relative_to(SOURCES).parts[0]
        )
        if place.parent.parent.is_dir():
            place.parent.mkdir(exist_ok=True)
            shutil.copy(compiled, place)
    return python


def test_a_wheel_needs_numpy_and_numba_alone(plain, tmp_path):
    result = run(plain, '-c', NOTEBOOK, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert Path(result.stdout.strip()).is_relative_to(plain.parents[1])


def test_a_wheel_names_what_lacks(plain, tmp_path):
    result = run(plain, '-c', 'import red_queen as rq; rq.plot_chase(None)', cwd=tmp_path)
    assert "ModuleNotFoundError: No module named 'matplotlib'" in result.stderr


def test_the_python_of_the_clone_finds_the_library(tmp_path):
    result = run(ROOT / '.venv' / 'bin' / 'python', '-c', NOTEBOOK, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert Path(result.stdout.strip()).is_relative_to(SOURCES)


def test_a_shell_that_sourced_the_workspace_has_library_and_ros(tmp_path):
    code = 'import red_queen, rclpy, coevo_msgs.msg; print(red_queen.__file__)'
    script = f'source {ROOT}/scripts/activate; cd {tmp_path}; python3 -c "{code}"; ros2 pkg list'
    result = run('bash', '-c', script, cwd=tmp_path)
    assert result.stderr == ''
    assert 'red_queen/__init__.py' in result.stdout.splitlines()[0]
    assert 'coevo_manager' in result.stdout.split()


@pytest.fixture(scope='module')
def example_folder(tmp_path_factory):
    """A folder with the run that the examples of docstrings read."""
    folder = tmp_path_factory.mktemp('examples')
    settings = {'population': 8, 'selected': 2, 'generations': 5, 'swap_generations': 10}
    rq.evolve(folder / 'runs' / 'mine', phases=4, snapshot_generations=10, **settings)
    return folder


VALUES = {
    'SPECIES',
    'WORLDS',
    '__version__',
    'Champion',
    'Configuration',
    'GenerationStats',
    'Outcome',
    'PhaseStats',
    'Replication',
    'RunFolderError',
    'Snapshot',
    'Trace',
}
"""What functions take and give: their examples show it."""

PUBLIC = [
    (module, name)
    for module in (rq, environments)
    for name in module.__all__
    if name not in VALUES
]


@pytest.mark.parametrize(('module', 'name'), PUBLIC, ids=[name for _, name in PUBLIC])
def test_examples_of_public_names_run(module, name, example_folder, monkeypatch):
    monkeypatch.chdir(example_folder)
    public = getattr(module, name)
    globs = dict(vars(sys.modules[public.__module__]))
    (found,) = doctest.DocTestFinder(recurse=False).find(public, name, globs=globs)
    assert found.examples
    assert doctest.DocTestRunner().run(found).failed == 0

"""What holds for every package: independence, declared imports, equal versions."""

import ast
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from ros_processes import ROOT

SOURCES = ROOT / 'ros2_ws' / 'src'
INDIRECT = {'python3-cryptography'}
"""What a library that we import needs for what we ask of it: Dask makes credentials with it."""

PACKAGES = sorted(path.parent.name for path in SOURCES.glob('*/package.xml'))
PYTHON_PACKAGES = sorted(path.parent.name for path in SOURCES.glob('*/setup.py'))
LOCAL_TEST_MODULES = {
    path.stem for folder in ('tests', 'scripts/lib') for path in (ROOT / folder).iterdir()
}

ALONE = """
import importlib, pkgutil, sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        top = name.partition('.')[0]
        if top in ('rclpy', 'ament_index_python', 'node_runner') or top.endswith(
            ('_msgs', '_srvs', '_interfaces')
        ):
            raise ModuleNotFoundError(f'{name} is blocked', name=name)

sys.meta_path.insert(0, Blocker())
root = importlib.import_module(sys.argv[1])
for module in pkgutil.walk_packages(root.__path__, root.__name__ + '.'):
    print(importlib.import_module(module.name).__name__)
"""


def imports(path: Path) -> set[str]:
    """Top-level names that a module imports from outside its own package."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module)
    return {name.partition('.')[0] for name in names}


def package_imports(package: str, folder: str) -> set[str]:
    return set().union(*(imports(path) for path in (SOURCES / package / folder).rglob('*.py')))


def manifest(package: str) -> ElementTree.Element:
    return ElementTree.parse(SOURCES / package / 'package.xml').getroot()


def setup_arguments(package: str) -> dict[str, ast.expr]:
    """Arguments of the call of setup() in a package's setup.py."""
    for node in ast.walk(ast.parse((SOURCES / package / 'setup.py').read_text())):
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'setup':
            return {keyword.arg: keyword.value for keyword in node.keywords}
    raise AssertionError(f'{package}/setup.py calls no setup()')


@pytest.mark.parametrize(
    'package',
    [
        'simd_lanes',
        'marxbot_sensors',
        'marxbot_sim.core',
        'neuro_controller.core',
        'robot_senses.core',
        'coevo_manager.core',
    ],
)
def test_core_imports_without_ros(package):
    paths = ':'.join(str(SOURCES / name) for name in PYTHON_PACKAGES)
    result = subprocess.run(
        [sys.executable, '-c', ALONE, package],
        env={'PYTHONPATH': paths, 'PATH': '/usr/bin:/bin'},
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    files = (SOURCES / package.partition('.')[0] / package.replace('.', '/')).rglob('*.py')
    modules = sum(path.name != '__init__.py' for path in files)
    assert len(result.stdout.split()) >= modules > 0


@pytest.mark.parametrize('package', PYTHON_PACKAGES)
def test_manifest_names_every_import(package):
    root = manifest(package)
    run = {entry.text for tag in ('depend', 'exec_depend') for entry in root.iter(tag)}
    test = run | {entry.text for entry in root.iter('test_depend')}
    foreign = sys.stdlib_module_names | LOCAL_TEST_MODULES | {package}
    for folder, declared in ((package, run), ('test', test)):
        wanted = {
            name if name in PACKAGES or _is_ros(name) else _rosdep(name)
            for name in package_imports(package, folder) - foreign
        }
        assert sorted(wanted - declared) == []


def _rosdep(name: str) -> str:
    return f'python3-{name.lower().replace("_", "-")}'


def _is_ros(name: str) -> bool:
    return name.endswith(('_msgs', '_srvs', '_interfaces')) or name in {
        'rclpy',
        'ament_index_python',
        'tf2_ros',
        'launch',
        'launch_ros',
    }


@pytest.mark.parametrize('package', PYTHON_PACKAGES)
def test_manifest_names_nothing_unused(package):
    root = manifest(package)
    declared = {entry.text for entry in root.iter('exec_depend')}
    used = package_imports(package, package)
    launched = ''.join(
        path.read_text() for path in (SOURCES / package).rglob('*') if path.suffix == '.xml'
    )
    unused = declared - used - {_rosdep(name) for name in used} - INDIRECT
    assert sorted(name for name in unused if f'pkg="{name}"' not in launched) == []


def test_versions_are_equal():
    versions = {package: manifest(package).findtext('version') for package in PACKAGES}
    versions |= {
        f'{package}/setup.py': ast.literal_eval(setup_arguments(package)['version'])
        for package in PYTHON_PACKAGES
    }
    versions['pyproject.toml'] = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project'][
        'version'
    ]
    assert len(set(versions.values())) == 1, versions


@pytest.mark.parametrize('package', PYTHON_PACKAGES)
def test_colcon_test_would_run_pytest(package):
    assert ast.literal_eval(setup_arguments(package)['extras_require']) == {'test': ['pytest']}

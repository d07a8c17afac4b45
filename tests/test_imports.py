"""Who imports whom, found in the sources: no circles, and every layer looks down only."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest
from ros_processes import ROOT

SOURCES = ROOT / 'ros2_ws' / 'src'
PACKAGES = sorted(path.parent.name for path in SOURCES.glob('*/setup.py'))

CORE_BELOW = ('rclpy', 'node_runner', 'ament_index_python', 'launch')
"""What no core may know."""

FORBIDDEN = {
    'marxbot_sim': ('neuro_controller', 'coevo_manager', 'coevo_msgs'),
    'neuro_controller': ('marxbot_sim', 'coevo_manager', 'coevo_msgs'),
    'robot_senses': ('marxbot_sim', 'neuro_controller', 'coevo_manager', 'coevo_msgs'),
    'marxbot_sensors': ('marxbot_sim', 'neuro_controller', 'coevo_manager', 'simd_lanes'),
    'simd_lanes': ('marxbot_sim', 'neuro_controller', 'coevo_manager', 'node_runner'),
    'node_runner': ('marxbot_sim', 'neuro_controller', 'coevo_manager', 'simd_lanes'),
    'coevo_manager': ('red_queen',),
    'coevo_manager.core': (
        'coevo_manager.command_line',
        'coevo_manager.evaluators',
        'coevo_manager.runs',
        'coevo_manager.recording',
        'coevo_manager.analysis',
        'coevo_manager.dashboard',
    ),
    'coevo_manager.core.episodes': ('coevo_manager.core.evolution',),
    'coevo_manager.core.evolution': ('coevo_manager.core.episodes',),
    'coevo_manager.command_line': (
        'coevo_manager.evaluators',
        'coevo_manager.runs',
        'coevo_manager.recording',
        'coevo_manager.analysis',
        'coevo_manager.dashboard',
    ),
    'coevo_manager.evaluators': (
        'coevo_manager.runs',
        'coevo_manager.analysis',
        'coevo_manager.dashboard',
    ),
    'coevo_manager.recording': (
        'coevo_manager.runs',
        'coevo_manager.analysis',
        'coevo_manager.dashboard',
    ),
    'coevo_manager.analysis': (
        'coevo_manager.runs',
        'coevo_manager.evaluators',
        'coevo_manager.dashboard',
    ),
    'coevo_manager.runs': ('coevo_manager.analysis', 'coevo_manager.dashboard'),
    'coevo_manager.dashboard': (
        'coevo_manager.runs',
        'coevo_manager.evaluators',
        'coevo_manager.recording',
    ),
}
"""What each part must not import: who stands beside or above it."""


def modules(package: str) -> dict[str, Path]:
    """Modules of a package by their full name; a package's own is its ``__init__``."""
    names = {}
    for path in (SOURCES / package / package).rglob('*.py'):
        parts = path.relative_to(SOURCES / package).with_suffix('').parts
        names['.'.join(parts[:-1] if parts[-1] == '__init__' else parts)] = path
    return names


MODULES = {name: path for package in PACKAGES for name, path in modules(package).items()}


def imports(path: Path) -> set[str]:
    """Modules that a module imports, at its top or in a function; but not for type checkers."""
    found = set()
    tree = ast.parse(path.read_text())
    for_types = {
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, 'id', '') == 'TYPE_CHECKING'
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if node in for_types:
            continue
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path} imports relatively'
            for alias in node.names:
                inner = f'{node.module}.{alias.name}'
                found.add(inner if inner in MODULES else node.module)
    return found


GRAPH = {name: imports(path) for name, path in MODULES.items()}


def within(name: str, part: str) -> bool:
    return name == part or name.startswith(f'{part}.')


def test_there_is_no_circle():
    assert len(GRAPH) > 100
    ours = {name: found & MODULES.keys() for name, found in GRAPH.items()}
    tuple(graphlib.TopologicalSorter(ours).static_order())  # CycleError names the circle


def test_core_is_below_ros():
    known = {
        (name, found)
        for name in GRAPH
        if 'core' in name.split('.') or within(name, 'simd_lanes')
        for found in GRAPH[name]
    }
    assert len(known) > 100
    assert not {
        (name, found)
        for name, found in known
        if any(within(found, part) for part in CORE_BELOW)
        or found.partition('.')[0].endswith(('_msgs', '_srvs', '_interfaces'))
    }


@pytest.mark.parametrize('part', FORBIDDEN)
def test_layers_are_kept(part):
    inside = [name for name in GRAPH if within(name, part)]
    assert inside
    assert not {
        (name, found)
        for name in inside
        for found in GRAPH[name]
        if any(within(found, other) for other in FORBIDDEN[part])
    }


@pytest.mark.parametrize('name', ['environment', 'configuration', 'evolution'])
def test_describing_episodes_loads_no_kernel(name):
    code = f"import sys, coevo_manager.core.{name}; sys.exit('numba' in sys.modules)"
    paths = ':'.join(str(SOURCES / package) for package in PACKAGES)
    assert subprocess.run([sys.executable, '-c', code], env={'PYTHONPATH': paths}).returncode == 0

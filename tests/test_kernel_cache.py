"""Compiled kernels are cached on disk, and never outlive their sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk

SOURCES = Path(__file__).parents[1] / 'ros2_ws' / 'src'
PACKAGES = ('simd_lanes', 'marxbot_sim')
SEE = """
import numpy as np
from marxbot_sim.core.world import World
print(World().readings[0, 24:32].sum())
"""


def seen(folder):
    """How much of its camera the predator sees filled at the start, by the packages there."""
    environment = {k: v for k, v in os.environ.items() if k != 'NUMBA_CACHE_DIR'}
    environment['PYTHONPATH'] = os.pathsep.join(str(folder / name) for name in PACKAGES)
    run = subprocess.run(
        [sys.executable, '-c', SEE],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
        timeout=60,
    )
    return float(run.stdout)


def change(file, before, after):
    source = file.read_text()
    assert before in source
    file.write_text(source.replace(before, after))


def test_a_change_of_any_source_is_compiled(tmp_path):
    for name in PACKAGES:
        shutil.copytree(
            SOURCES / name / name,
            tmp_path / name / name,
            ignore=shutil.ignore_patterns('__pycache__'),
        )
    assert seen(tmp_path) == pytest.approx(2 * np.arcsin(0.085) / np.radians(45), abs=1e-4)
    assert list(tmp_path.rglob('*.nbc'))
    change(
        tmp_path / 'marxbot_sim' / 'marxbot_sim' / 'core' / 'parameters.py',
        'BODY_RADIUS = 0.085',
        'BODY_RADIUS = 0.170',
    )
    change(
        tmp_path / 'simd_lanes' / 'simd_lanes' / 'functions.py',
        'return fma(series * square, x, x)',
        'return x * 3.0',
    )
    assert seen(tmp_path) == pytest.approx(2 * 3 * 0.17 / np.radians(45), abs=1e-4)


def test_a_full_disk_only_costs_the_next_process_a_compilation(tmp_path):
    shutil.copytree(
        SOURCES / 'simd_lanes' / 'simd_lanes',
        tmp_path / 'simd_lanes' / 'simd_lanes',
        ignore=shutil.ignore_patterns('__pycache__'),
    )
    program = """
from simd_lanes import compile_kernel
import kernel
print(compile_kernel(kernel.double)(21))
"""
    (tmp_path / 'simd_lanes' / 'kernel.py').write_text('def double(x):\n    return 2 * x\n')
    with full_disk(10):
        run = subprocess.run(
            [sys.executable, '-c', program],
            env={**os.environ, 'PYTHONPATH': str(tmp_path / 'simd_lanes')},
            capture_output=True,
            text=True,
        )
    assert run.stdout == '42\n', run.stderr
    assert not list(tmp_path.rglob('*.nb?'))

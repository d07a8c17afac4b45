"""The same bits on every processor, and from plain Python."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from coevo_manager.core.episodes import Environment, measure_pairs
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.genome import random_genomes

SOURCES = Path(__file__).parents[1] / 'ros2_ws' / 'src'
PACKAGES = ('simd_lanes', 'marxbot_sim', 'neuro_controller', 'coevo_manager')
ENVIRONMENTS = [
    Environment(),
    Environment(obstacle=True),
    Environment(obstacle=True, wall_contact='undo', infrared_response='linear'),
    Environment(wall_friction=0.0, ground_coding='raw', motor_map='printed'),
    Environment(
        perturbations=Perturbations(
            infrared_noise=0.01,
            camera_noise=0.05,
            ground_noise=0.005,
            motor_noise=0.05,
            latency_ticks=1,
            battery=0.9,
            command_loss=0.05,
            wheel_separation_scale=0.95,
            start_displacement=0.3,
            start_rotation=3.0,
        ),
    ),
]
TARGETS = {
    'AVX2 with FMA': {'NUMBA_CPU_NAME': 'haswell', 'NUMBA_CPU_FEATURES': '+avx2,+fma'},
    'neither AVX nor FMA': {'NUMBA_CPU_NAME': 'x86-64', 'NUMBA_CPU_FEATURES': '+sse2'},
    'plain Python': {'NUMBA_DISABLE_JIT': '1'},
}


def episodes(count, ticks):
    """Capture ticks and complexities of ``count`` pairs in each environment, as bytes."""
    rng = np.random.default_rng(7)
    predators, prey, pairs = (
        random_genomes(count, rng),
        random_genomes(count, rng),
        np.arange(count),
    )
    results = []
    for each in ENVIRONMENTS:
        environment = dataclasses.replace(each, episode_ticks=ticks)
        results += measure_pairs(predators, prey, pairs, pairs, environment)
    return b''.join(part.tobytes() for part in results)


@pytest.fixture(scope='module')
def elsewhere(request):
    """The results on each target, computed by processes that run side by side.

    What they compile is kept for the next run of the tests: it is valid for these sources only.
    """
    running = {}
    for name, settings in TARGETS.items():
        folder = request.config.cache.mkdir(f'kernels {name}')
        environment = {
            **os.environ,
            **settings,
            'NUMBA_CACHE_DIR': str(folder),
            'PYTHONPATH': os.pathsep.join(
                [str(SOURCES / package) for package in PACKAGES] + [str(Path(__file__).parent)]
            ),
        }
        count, ticks = (4, 60) if 'NUMBA_DISABLE_JIT' in settings else (50, 1000)
        code = (
            'import sys, test_targets\n'
            f'sys.stdout.buffer.write(test_targets.episodes({count}, {ticks}))\n'
        )
        running[name] = (
            count,
            ticks,
            subprocess.Popen(
                [sys.executable, '-c', code], env=environment, stdout=subprocess.PIPE
            ),
        )
    try:
        yield {
            name: (count, ticks, process.communicate(timeout=250)[0], process.returncode)
            for name, (count, ticks, process) in running.items()
        }
    finally:
        for *_, process in running.values():
            process.kill()
            process.wait()


@pytest.mark.parametrize('target', TARGETS)
def test_results_are_equal_bit_for_bit(elsewhere, target):
    count, ticks, result, code = elsewhere[target]
    assert code == 0
    assert len(result) == len(ENVIRONMENTS) * count * 12
    assert result == episodes(count, ticks)

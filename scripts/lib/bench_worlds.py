"""Perfect and imperfect robots on LLVM's targets, played in turns; run itself, one target."""

import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from llvmlite import binding

from coevo_manager.analysis.transfer.measure import ALL
from coevo_manager.core.episodes import Environment, evaluate_pairs
from coevo_manager.core.evolution import load_configuration
from marxbot_sim.core.perturbations import Perturbations

AVX2 = {'NUMBA_CPU_NAME': 'haswell', 'NUMBA_CPU_FEATURES': '+avx2,+fma'}
WORLDS = {
    name: load_configuration({'world': name}).make_environment()
    for name in ('faithful', 'varied', 'robust')
} | {'all perturbations': Environment(perturbations=Perturbations(**ALL))}


def targets():
    """Return the environment variables of each target that this processor can run."""
    if binding.get_host_cpu_features().get('avx512f', False):
        return {'AVX-512': {}, 'AVX2': AVX2}
    return {'this processor': {}}


def measure_worlds(predators, prey, pairs, runs):
    """Return pair-ticks a second by target and world, a list with a value for each run.

    Every run plays the same pairs once in each world and on each target, so that whatever else the
    machine does meets all alike.
    """
    with tempfile.TemporaryDirectory() as folder, ExitStack() as running:
        file = Path(folder) / 'episodes.npz'
        np.savez(file, predators=predators, prey=prey, pairs=pairs)
        workers = {
            name: running.enter_context(
                subprocess.Popen(
                    [sys.executable, __file__, str(file)],
                    env=os.environ | variables,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    text=True,
                )
            )
            for name, variables in targets().items()
        }
        rates = {name: {world: [] for world in WORLDS} for name in workers}
        for run in range(runs + 1):  # the first warms up
            for name, worker in workers.items():
                for world in WORLDS:
                    print(world, file=worker.stdin, flush=True)
                    rate = float(worker.stdout.readline())
                    if run > 0:
                        rates[name][world].append(rate)
        return rates


def _serve(file):
    """Play the file's pairs in each world that standard input names; print the rate."""
    with np.load(file, allow_pickle=False) as arrays:
        predators, prey, pairs = (arrays[name] for name in ('predators', 'prey', 'pairs'))
    for line in sys.stdin:
        start = time.perf_counter()
        ticks = evaluate_pairs(predators, prey, *pairs, WORLDS[line.rstrip('\n')]).sum()
        print(ticks / (time.perf_counter() - start), flush=True)


if __name__ == '__main__':
    _serve(sys.argv[1])

"""How much of the kernel's speed evolve keeps: the loop through services, the kernel alone."""

from __future__ import annotations

import shutil
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import rclpy

from coevo_manager.core.episodes import evaluate_pairs
from coevo_manager.core.evaluation import (
    Batch,
    Evaluator,
    Lineages,
    all_pairs,
    evaluate_all,
    joined,
)
from coevo_manager.core.evolution import Evolution, PhaseStats, load_configuration
from coevo_manager.core.local_evaluator import LocalEvaluator
from coevo_manager.evaluators.pool import RosEvaluator
from neuro_controller.core.genome import GENES
from node_runner import start_ros


class _Recorder(LocalEvaluator):
    """Keeps every episode that was played, as batches, by phase."""

    def __init__(self, environment, threads: int) -> None:
        super().__init__(environment, threads)
        self.phases: list[list[Batch]] = []
        self._batches: list[Batch] = []
        self._works: dict[int, Batch | Lineages] = {}

    def submit(self, work: Batch | Lineages) -> int:
        ticket = super().submit(work)
        self._works[ticket] = work
        return ticket

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        answer = super().collect(timeout)
        if answer is not None:
            work = self._works.pop(answer[0])
            if isinstance(work, Lineages):
                work = all_pairs(work.species, work.offspring(answer[1]), work.opponents)
            self._batches.append(work)
        return answer

    def end_phase(self) -> None:
        """Take what was played since the last call for a phase."""
        self.phases.append(self._batches)
        self._batches = []


def measure_loop(
    evaluators: int = 2,
    warm_up: int = 40,
    phases: int = 10,
    repeats: int = 3,
    optimizer: str = 'one_plus_one',
) -> dict[str, list[float]]:
    """Compare evolve through services with the kernel alone on the same episodes.

    Parameters
    ----------
    evaluators : int
        Evaluator processes, and threads of the kernel alone.
    warm_up : int
        Phases of the algorithm Standard, of 100 generations, that are run before, untimed.
    phases : int
        Phases that are timed.
    repeats : int
        How often both are timed, alternately.
    optimizer : str

    Returns
    -------
    dict
        ``loop`` and ``kernel``: ticks/s of each repeat; ``ratio``: of each pair;
        ``processor``: processor time of the kernel alone by that of the run and its evaluators;
        ``generation``: wall-clock time of one in the loop, s; ``episode``: mean length, ticks.
    """
    # One phase more, untimed: the first one after a run is resumed.
    configuration = load_configuration(
        {'phases': warm_up + 1 + phases, 'optimizer': optimizer}, 'paper'
    )
    environment = configuration.make_environment()
    result: dict[str, list[float]] = {
        name: [] for name in ('loop', 'kernel', 'ratio', 'processor', 'generation', 'episode')
    }
    with tempfile.TemporaryDirectory() as folder:
        start = Path(folder, 'start')
        _run_phases(configuration, LocalEvaluator(environment, evaluators), start, warm_up)
        recorder = _Recorder(environment, evaluators)
        _go_on(start, recorder, recorder.end_phase)
        episodes = joined([batch for phase in recorder.phases[1:] for batch in phase])
        start_ros(['bench'])
        node = rclpy.create_node('bench')
        pool = RosEvaluator(node, environment, evaluators, print)
        try:
            pool.start(threading.Event())
            while pool.evaluators < evaluators:
                evaluate_all(pool, *[np.zeros((1, GENES), np.float32)] * 2, threading.Event())
            for _ in range(repeats):
                processor, seconds, ticks, generations = _go_on(start, pool)
                result['loop'].append(ticks / seconds)
                result['generation'].append(seconds / generations)
                begun, computed = time.perf_counter(), time.process_time()
                played = evaluate_pairs(
                    episodes.predators,
                    episodes.prey,
                    episodes.predator_index,
                    episodes.prey_index,
                    environment,
                    evaluators,
                )
                seconds = time.perf_counter() - begun
                result['processor'].append((time.process_time() - computed) / processor)
                result['kernel'].append(int(played.sum(dtype=np.int64)) / seconds)
                result['ratio'].append(result['loop'][-1] / result['kernel'][-1])
                result['episode'].append(float(played.mean()))
        finally:
            pool.close()
            node.destroy_node()
            rclpy.try_shutdown()
    return result


def _run_phases(configuration, evaluator: Evaluator, folder: Path, phases: int) -> None:
    """Begin a run and stop it after some phases."""

    def observe(stats) -> None:
        if isinstance(stats, PhaseStats) and stats.phase == phases:
            evolution.stop()

    evolution = Evolution(configuration, evaluator, folder, observe)
    evolution.run()


def _go_on(
    start: Path, evaluator: Evaluator, on_phase: Callable[[], object] = lambda: None
) -> tuple[float, float, int, int]:
    """Go on with a copy of a run to its end.

    Returns the processor's seconds, the seconds, ticks and generations of all phases but the
    first; `on_phase` is called after each.
    """
    processes = [psutil.Process(), *psutil.Process().children()]
    moments: list[tuple[float, float, PhaseStats]] = []

    def observe(stats) -> None:
        if isinstance(stats, PhaseStats):
            on_phase()
            times = [process.cpu_times() for process in processes]
            computed = sum(each.user + each.system for each in times)
            moments.append((computed, time.perf_counter(), stats))

    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(start, folder, dirs_exist_ok=True)
        Evolution.resume(folder, evaluator, observe).run()
    (computed, begun, first), (all_computed, ended, last) = moments[0], moments[-1]
    return (
        all_computed - computed,
        ended - begun,
        last.ticks - first.ticks,
        last.generation - first.generation,
    )


if __name__ == '__main__':
    for name, values in measure_loop().items():
        print(name, *(f'{value:.4g}' for value in values))

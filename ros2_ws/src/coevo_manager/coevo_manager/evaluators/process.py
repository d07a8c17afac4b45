"""An evaluator node in a process of its own, started and ended by a run."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time

import psutil

from node_runner.children import Child

END_TIMEOUT = 1.2
"""How long evaluators may take to end after SIGTERM before they are killed, s."""

OWN_PREFIX = '/_evolve_'
"""Namespaces of evaluators that belong to one run; hidden by the rules of ROS names."""

_serial = itertools.count()


class EvaluatorProcess(Child):
    """One evaluator process.

    Attributes
    ----------
    service : str
        Full name of its service.
    cpu_seconds : float
        What it has computed when `idle_seconds` was asked for last, s of CPU time.
    """

    def __init__(self) -> None:
        namespace = f'{OWN_PREFIX}{os.getpid()}/evaluator_{next(_serial)}'
        self.service = f'{namespace}/evaluate_batch'
        self._errors = tempfile.TemporaryFile(mode='w+', errors='replace')  # noqa: SIM115
        super().__init__(
            [
                *(sys.executable, '-m', 'coevo_manager.evaluators.evaluator'),
                *('--ros-args', '-r', f'__ns:={namespace}'),
            ],
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            # The kernel is its only work: no threads of BLAS beside it.
            env=os.environ | {'OPENBLAS_NUM_THREADS': '1'},
        )
        self.cpu_seconds = 0.0
        self._computed_at = time.monotonic()

    def idle_seconds(self) -> float:
        """Return for how long it has computed nothing, as far as it was looked at."""
        try:
            user, system, *_ = psutil.Process(self.pid).cpu_times()
        except psutil.Error:
            user = system = 0.0
        if user + system > self.cpu_seconds:
            self.cpu_seconds = user + system
            self._computed_at = time.monotonic()
        return time.monotonic() - self._computed_at

    def ending(self) -> str | None:
        """Return how the process ended, in words; None while it runs."""
        code = self.poll()
        if code is None:
            return None
        how = f'by {signal.Signals(-code).name}' if code < 0 else f'with exit code {code}'
        self._errors.seek(0)
        lines = self._errors.read().split('\n')
        words = next((line.strip() for line in reversed(lines) if line.strip()), '')
        return f'{how}: {words}' if code > 0 and words else how

    def end_at_once(self) -> None:
        """End the process, hung or not."""
        self.kill()
        self.wait()
        self._errors.close()

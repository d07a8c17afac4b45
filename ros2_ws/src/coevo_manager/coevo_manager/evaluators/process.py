"""An evaluator node in a process of its own, started and ended by a run."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time

END_TIMEOUT = 1.2
"""How long evaluators may take to end after SIGTERM before they are killed, s."""

OWN_PREFIX = '/_evolve_'
"""Namespaces of evaluators that belong to one run; hidden by the rules of ROS names."""

_serial = itertools.count()


class EvaluatorProcess:
    """One evaluator process.

    It does not get the terminal's Ctrl-C, since its run ends it, and the kernel ends it should the
    run be killed.

    Attributes
    ----------
    service : str
        Full name of its service.
    """

    def __init__(self) -> None:
        namespace = f'{OWN_PREFIX}{os.getpid()}/evaluator_{next(_serial)}'
        self.service = f'{namespace}/evaluate_batch'
        self._errors = tempfile.TemporaryFile(mode='w+', errors='replace')  # noqa: SIM115
        self._process = subprocess.Popen(
            [
                *(
                    sys.executable,
                    '-m',
                    'coevo_manager.evaluators.evaluator',
                    '--parent',
                    str(os.getpid()),
                ),
                *('--ros-args', '-r', f'__ns:={namespace}'),
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            process_group=0,
            # The kernel is its only work: no threads of BLAS beside it.
            env=os.environ | {'OPENBLAS_NUM_THREADS': '1'},
        )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def ending(self) -> str | None:
        """Return how the process ended, in words; None while it runs."""
        code = self._process.poll()
        if code is None:
            return None
        how = f'by {signal.Signals(-code).name}' if code < 0 else f'with exit code {code}'
        self._errors.seek(0)
        lines = self._errors.read().split('\n')
        words = next((line.strip() for line in reversed(lines) if line.strip()), '')
        return f'{how}: {words}' if code > 0 and words else how

    def kill(self) -> None:
        """End the process at once, hung or not."""
        self._process.kill()
        self._process.wait()
        self._errors.close()

    @staticmethod
    def end_all(processes: list[EvaluatorProcess]) -> None:
        """End processes and wait for them, killing those that take too long."""
        for process in processes:
            process._process.terminate()
        deadline = time.monotonic() + END_TIMEOUT
        for process in processes:
            try:
                process._process.wait(max(0.0, deadline - time.monotonic()))
                process._errors.close()
            except subprocess.TimeoutExpired:
                process.kill()

"""The page of a run: a dashboard in a process of its own, which the run does not need."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from node_runner.children import Child, end_all

PATIENCE = 0.5
"""How long the dashboard may take to end before it is killed, s: it has nothing to lose."""


class Page:
    """Starts the dashboard once there is a run to show, and ends it with the run.

    Parameters
    ----------
    folder : Path
        The run's.
    tell : callable
        Called with a sentence, from a thread of its own.
    """

    def __init__(self, folder: Path, tell: Callable[[str], None]) -> None:
        self._folder = folder
        self._tell = tell
        self._child: Child | None = None

    def open(self) -> None:
        """Start the dashboard, once."""
        if self._child is not None:
            return
        self._child = Child(
            [sys.executable, '-m', 'coevo_manager.dashboard.command', self._folder],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        threading.Thread(target=self._pass_on, args=(self._child,), daemon=True).start()

    def close(self) -> None:
        """End the dashboard."""
        if self._child is not None:
            end_all([self._child], PATIENCE)

    @staticmethod
    def _address(line: str) -> str:
        return f'dashboard: {line.strip().removeprefix("dashboard: ")}'

    def _pass_on(self, child: Child) -> None:
        """Tell what the dashboard prints first, its address or why there is none."""
        assert child.stdout is not None
        first = child.stdout.readline()
        if first:
            self._tell(self._address(first))
        for _ in child.stdout:  # so that it never waits for a reader
            pass

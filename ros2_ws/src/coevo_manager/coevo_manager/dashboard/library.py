"""The runs that are watched: those in and under the folders that were given."""

from __future__ import annotations

import hashlib
import itertools
import os
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from coevo_manager.dashboard.watched import WatchedRun

DEPTH = 4
"""Folders deep that runs are looked for."""

MOST_RUNS = 1000
"""In or under one folder."""

LOOK_PERIOD = 1.0
"""Shortest time between two looks at the runs, s, ..."""

FIND_PERIOD = 5.0
"""... and between two searches for new ones."""


class Library:
    """Finds runs and keeps up with them; for any thread.

    Parameters
    ----------
    folders : sequence of Path
        Run folders, or folders with runs under them. No link in them is followed.

    Attributes
    ----------
    problems : list of str
        Why folders that hold a run cannot be shown, a sentence each.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = [folder.resolve() for folder in folders]
        self._runs: dict[str, WatchedRun] = {}
        self._summaries: dict[str, dict[str, Any]] = {}
        self.problems: list[str] = []
        self._lock = threading.Lock()
        self._next_look = self._next_find = 0.0

    def look(self) -> dict[str, dict[str, Any]]:
        """Return the summary of every run, by its key; at most a second old."""
        with self._lock:
            now = time.monotonic()
            if now >= self._next_find:
                self._find()
                self._next_find = now + FIND_PERIOD
            if now >= self._next_look:
                self._summaries = {key: run.look() for key, run in self._runs.items()}
                self._next_look = now + LOOK_PERIOD
            return self._summaries

    def run(self, key: str) -> WatchedRun | None:
        """Return the run of a key; None where there is none such."""
        return self._runs.get(key)

    def _find(self) -> None:
        runs: dict[str, WatchedRun] = {}
        problems = []
        for root in self._folders:
            for folder in itertools.islice(run_folders(root), MOST_RUNS):
                key = hashlib.sha256(os.fsencode(folder)).hexdigest()[:16]
                name = folder.name if folder == root else str(folder.relative_to(root))
                try:
                    runs[key] = self._runs.get(key) or WatchedRun(key, name, folder)
                except ValueError as error:
                    problems.append(str(error))
        self._runs, self.problems = runs, problems


def run_folders(root: Path) -> Iterator[Path]:
    """Yield the run folders in and under a folder, in order; links are not followed."""
    for place, folders, files in os.walk(root):
        folder = Path(place)
        if 'run.json' in files:
            folders.clear()
            yield folder
        elif len(folder.relative_to(root).parts) >= DEPTH:
            folders.clear()
        folders[:] = sorted(name for name in folders if not name.startswith('.'))

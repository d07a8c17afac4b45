"""Files of a run that grow while they are read."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from coevo_manager.analysis.logs import LIMIT, parse_log
from neuro_controller.core.reading import ReadingError, opened, reading

TAIL = 2**14
"""Bytes at the end of run.log in which the last events are looked for."""


def within(folder: Path, *parts: str) -> Path:
    """Return a path inside a folder.

    Raises
    ------
    ReadingError
        The way there leads over a symbolic link, and so perhaps outside.
    """
    path = folder
    for part in parts:
        path = path / part
        if path.is_symlink():
            raise ReadingError(f'{path} is a symbolic link, which is not followed')
    return path


def changed(path: Path) -> tuple[int, int]:
    """Return what differs between two contents of a file: its time and its size; 0 without one."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_mtime_ns, found.st_size


class GrowingLog:
    """generations.csv or phases.csv of a run: only what was added since is read again.

    Parameters
    ----------
    path : Path
    columns : sequence of str
        As for `read_columns`.

    Attributes
    ----------
    table : DataFrame
        All whole lines so far.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self.path = path
        self._columns = columns
        self._forget()

    def _forget(self) -> None:
        self.table = pd.DataFrame(columns=list(self._columns))
        self._read = 0

    def grow(self) -> bool:
        """Read what is new; return whether there was something.

        Raises
        ------
        ReadingError
            A line is damaged, and with it all that follows.
        """
        size = changed(self.path)[1]
        if size < self._read:  # a run that was resumed has cut it
            self._forget()
        if size == self._read:
            return False
        with reading(self.path):
            with opened(self.path) as file:
                file.seek(self._read)
                content = file.read(LIMIT)
            whole = content[: content.rfind(b'\n') + 1]
            first = len(self.table) + 2 if self._read else 1
            rows = parse_log(whole.decode(), self._columns, first) if whole else None
        if rows is None:
            return False
        self._read += len(whole)
        self.table = pd.concat([self.table, rows], ignore_index=True) if len(self.table) else rows
        return True


def last_events(path: Path, count: int) -> list[str]:
    """Return the last lines of a run.log that tell of more than a completed phase."""
    try:
        with opened(path) as file:
            start = max(file.seek(0, os.SEEK_END) - TAIL, 0)
            file.seek(start)
            lines = file.read(TAIL).decode(errors='replace').split('\n')
    except OSError:
        return []
    whole = lines[1 if start else 0 : -1]
    return [line for line in whole if ' completed phase ' not in line][-count:]

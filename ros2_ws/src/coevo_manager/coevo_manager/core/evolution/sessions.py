"""When, where and for how long a run was computed: facts that no result depends on."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import platform
import reprlib
import time
from pathlib import Path
from typing import Any

from coevo_manager.core.evolution.commit import source_commit
from coevo_manager.core.evolution.files import write_whole
from neuro_controller.core.reading import ReadingError, parse_json, read_text, reading

NAME = 'sessions.json'


class Session:
    """One stretch of a run, from its start or a resuming to its end or a stop.

    It is an entry of ``sessions.json``, a list: `host`, `process`, `cores`, `commit`, `begun`
    (local time), `first_phase` and `last_phase` completed, `seconds`, and how it `ended`; while it
    goes on, and after a kill, the last two are null. An entry that finds no room on the disk is
    lost.

    Parameters
    ----------
    folder : Path
        The run's.
    phase : int
        Phases completed before.
    """

    def __init__(self, folder: Path, phase: int) -> None:
        self._path = folder / NAME
        self._start = time.monotonic()
        self._former = read_sessions(folder)
        self._entry: dict[str, Any] = {
            'host': platform.node(),
            'process': os.getpid(),
            'cores': len(os.sched_getaffinity(0)),
            'commit': source_commit() or None,
            'begun': datetime.datetime.now().astimezone().isoformat(timespec='seconds'),
            'first_phase': phase,
            'last_phase': phase,
            'seconds': None,
            'ended': None,
        }
        self._write()

    def end(self, phase: int, how: str) -> None:
        """Note the last phase completed, how the session ended and how long it took."""
        seconds = round(time.monotonic() - self._start, 3)
        self._entry |= {'last_phase': phase, 'seconds': seconds, 'ended': how}
        self._write()

    def _write(self) -> None:
        text = json.dumps([*self._former, self._entry], indent=2) + '\n'
        with contextlib.suppress(OSError):
            write_whole(self._path, text.encode())


def remark_on_program(folder: Path) -> str:
    """Return a sentence where another commit of the program goes on with a run; '' otherwise."""
    former = read_sessions(folder)
    if not former:
        return ''
    before, now = former[-1].get('commit'), source_commit() or None
    if before == now:
        return ''
    return (
        f'its last session was of commit {reprlib.repr(before)}, this one is of {now}: where '
        'their episodes differ, neither commit alone repeats this run'
    )


def read_sessions(folder: Path) -> list[dict[str, Any]]:
    """Return the sessions of the run in a folder, the first one first; none where none is told."""
    path = folder / NAME
    try:
        with reading(path):
            sessions = parse_json(read_text(path))
    except ReadingError:
        return []
    if not isinstance(sessions, list):
        return []
    return [entry for entry in sessions if isinstance(entry, dict)]

"""One run as a reader sees it: what its folder tells, while it goes on and after."""

from __future__ import annotations

import contextlib
import datetime
import math
import platform
import time
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import psutil

from coevo_manager.core.environment import Environment
from coevo_manager.core.evolution.budget import RunBudget
from coevo_manager.core.evolution.checkpoint import load, newest_first
from coevo_manager.core.evolution.run_folder import LOGS, RunFolderError, read_record
from coevo_manager.core.evolution.sessions import read_sessions
from coevo_manager.core.species import SPECIES
from coevo_manager.dashboard.growing import GrowingLog, changed, last_events, within
from neuro_controller.core.reading import ReadingError, parse_json, read_text
from neuro_controller.core.snapshot import Snapshot, read_snapshot, snapshots

EVENTS = 30
"""Lines of run.log that are told."""

SILENCE = 120.0
"""A run of which no process is known here goes on if it wrote something in so many seconds."""

START_TOLERANCE = 5.0
"""A process that began so much later than a session does not carry it on, s."""

_FILES = (
    *('sessions.json', 'status.json', 'run.log', 'generations.csv', 'phases.csv', 'snapshots'),
)
"""What changes in a run folder."""

NOW = 'now'
"""Stands for the generation that a run has reached, of which there may be no snapshot."""

_NUMBERS = (
    *('phase', 'generation', 'episodes', 'ticks', 'progress', 'fitness_mean', 'accepted'),
    *('predator_fitness', 'prey_fitness', 'ticks_per_second', 'seconds_left'),
)
_LISTS = ('evaluators', 'losses')
_OF_THE_RUN = ('ticks_per_second', 'seconds_left', *_LISTS)
"""What a status tells that the logs do not, even where they are ahead of it."""


class WatchedRun:
    """Keeps up with a run folder; it only reads.

    Parameters
    ----------
    key : str
        What the page calls it.
    name : str
        For people.
    folder : Path

    Raises
    ------
    ReadingError
        It holds no run.
    """

    def __init__(self, key: str, name: str, folder: Path) -> None:
        self.key = key
        self.name = name
        self.folder = folder
        try:
            self.configuration, self.condition = read_record(within(folder, 'run.json'))
        except RunFolderError as error:
            raise ReadingError(str(error)) from None
        self.generations, self.phases = (
            GrowingLog(folder / f'{log}.csv', LOGS[log]) for log in ('generations', 'phases')
        )
        self._budget = RunBudget(self.configuration)
        self._seen: tuple[Any, ...] = ()
        self._sessions: list[dict[str, Any]] = []
        self._status: dict[str, Any] = {}
        self._snapshots: dict[int, Path] = {}
        self._about = {
            'key': key,
            'name': name,
            'folder': str(folder),
            'condition': self.condition,
            'configuration': self.configuration.as_dict(),
        }
        self._events: list[str] = []
        self._problem = ''

    @cached_property
    def environment(self) -> Environment:
        """Where its individuals meet on the page: each pair plays once."""
        return replace(self.configuration.make_environment(), repetitions=1)

    def look(self) -> dict[str, Any]:
        """Read what has changed and return where the run stands, ready for JSON."""
        try:
            seen = tuple(changed(within(self.folder, name)) for name in _FILES)
            if seen != self._seen:
                self._read()
                self._seen, self._problem = seen, ''
        except ReadingError as error:
            self._problem = str(error)
        state = self._state()
        return {
            **self._about,
            'state': state,
            'problem': self._problem,
            'begun': self._sessions[0].get('begun') if self._sessions else None,
            'host': self._session.get('host'),
            'events': self._events,
            'snapshots': list(self._snapshots),
            **self._progress(state),
        }

    @property
    def snapshots(self) -> tuple[int, ...]:
        """Generations of its snapshots, in order."""
        return tuple(self._snapshots)

    def snapshot(self, generation: str) -> Snapshot:
        """Read the populations of a generation, or those of `NOW`, from the last checkpoint.

        Raises
        ------
        ReadingError
            There are none such, or the file is damaged.
        """
        if generation == NOW:
            return self._now()
        path = self._snapshots.get(int(generation)) if generation.isdecimal() else None
        if path is None:
            raise ReadingError(f'{self.name} has no snapshot of generation {generation[:20]!r}')
        return read_snapshot(within(self.folder, 'snapshots', path.name))

    def _now(self) -> Snapshot:
        for path in newest_first(within(self.folder, 'checkpoint')):
            state, *_ = load(within(self.folder, 'checkpoint', path.name), self.configuration)
            fitness = np.asarray(state.fitness('predator'), float) / state.pair_ticks
            return Snapshot(state.generation, state.predators, state.prey, fitness)
        raise ReadingError(f'{self.name} has no checkpoint')

    def _read(self) -> None:
        self._sessions = read_sessions(self.folder)
        self._status = self._read_status()
        self._events = last_events(self.folder / 'run.log', EVENTS)
        with contextlib.suppress(ValueError):  # there is none yet
            self._snapshots = snapshots(self.folder)
        self.generations.grow()
        self.phases.grow()

    def _read_status(self) -> dict[str, Any]:
        try:
            status = parse_json(read_text(self.folder / 'status.json'))
        except (ReadingError, ValueError):
            return {}
        if not isinstance(status, dict):
            return {}
        found = {name: status.get(name) for name in _NUMBERS if _is_number(status.get(name))}
        if status.get('evolving') in SPECIES:
            found['evolving'] = status['evolving']
        for name in _LISTS:
            entries = status.get(name)
            if isinstance(entries, list):
                found[name] = [entry for entry in entries if isinstance(entry, dict)]
        return found

    @property
    def _session(self) -> dict[str, Any]:
        return self._sessions[-1] if self._sessions else {}

    def _state(self) -> str:
        """Return 'running', 'finished', 'stopped', 'failed', 'killed' or 'silent'."""
        session = self._session
        if session.get('ended') in ('finished', 'stopped', 'failed'):
            return session['ended']
        if not session:
            return 'finished' if (self.folder / 'report.md').exists() else 'stopped'
        if session.get('host') == platform.node() and isinstance(session.get('process'), int):
            return 'running' if _carries_on(session) else 'killed'
        last = max((time_ns for time_ns, _ in self._seen), default=0) / 1e9
        return 'running' if time.time() - last < SILENCE else 'silent'

    def _progress(self, state: str) -> dict[str, Any]:
        """Return how far the run is: from its status while it runs, else from its logs."""
        found: dict[str, Any] = dict.fromkeys((*_NUMBERS, *_LISTS, 'evolving', 'retained'))
        if len(self.phases.table):
            last = self.phases.table.iloc[-1]
            counts = {
                name: int(last[name])
                for name in ('phase', 'generation', 'episodes', 'ticks', 'retained')
            }
            spent = self._budget.progress(
                counts['generation'], counts['episodes'], counts['ticks']
            )
            found |= counts | {
                'evolving': last['evolving'],
                'predator_fitness': float(last['predator_fitness']),
                'prey_fitness': float(last['prey_fitness']),
                'progress': 1.0 if state == 'finished' else spent,
            }
        if len(self.generations.table):
            last = self.generations.table.iloc[-1]
            found |= {
                'fitness_mean': float(last['fitness_mean']),
                'accepted': int(last['accepted']),
            }
        if state == 'running':
            behind = self._status.get('generation', -1) < (found['generation'] or 0)
            names = _OF_THE_RUN if behind else self._status
            found |= {name: self._status[name] for name in names if name in self._status}
        else:
            found['losses'] = self._status.get('losses')
            found['ticks_per_second'] = self._mean_rate(found['ticks'])
        return found

    def _mean_rate(self, ticks: int | None) -> float | None:
        """Return the ticks a second of a run that has ended, where all its sessions tell."""
        seconds = [session.get('seconds') for session in self._sessions]
        known = [each for each in seconds if _is_number(each)]
        if ticks is None or not known or len(known) < len(seconds):
            return None
        return ticks / max(sum(known), 0.1)


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and math.isfinite(value)


def _carries_on(session: dict[str, Any]) -> bool:
    """Return whether the process of a session still runs."""
    try:
        process = psutil.Process(session['process'])
        begun = datetime.datetime.fromisoformat(session['begun']).timestamp()
        return (
            process.status() != psutil.STATUS_ZOMBIE
            and process.create_time() < begun + START_TOLERANCE
        )
    except (psutil.Error, ValueError, KeyError, TypeError, OverflowError):
        return False

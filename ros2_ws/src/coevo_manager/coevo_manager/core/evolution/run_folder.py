"""The folder of a run: configuration, logs, snapshots, checkpoints, report (docs/formats.md)."""

from __future__ import annotations

import contextlib
import copy
import datetime
import fcntl
import hashlib
import json
import os
import platform
import reprlib
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from coevo_manager import __version__
from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution import checkpoint
from coevo_manager.core.evolution.algorithm import Algorithm
from coevo_manager.core.evolution.commit import source_commit
from coevo_manager.core.evolution.files import (
    OWN,
    TEMPORARY,
    DurableLog,
    npz_bytes,
    write_whole,
)
from coevo_manager.core.evolution.loading import load_configuration
from coevo_manager.core.evolution.observation import GenerationStats, PhaseStats
from coevo_manager.core.evolution.seal import Seal, log_name, snapshot_name
from coevo_manager.core.evolution.state import State
from neuro_controller.core.reading import ReadingError, parse_json, read_text, reading
from neuro_controller.core.settings import FIRST_RUNS

VERSION = 1

"""Version of run.json, the logs and the snapshots."""

HEAD_START = 0.01
"""How long a completed phase waits to be written, s, as long as nobody waits for that: the work of
the next phase is handed out first."""

GENERATION_COLUMNS = (
    'generation', 'phase', 'evolving', 'fitness_mean', 'fitness_min', 'fitness_max', 'accepted',
    'episodes', 'ticks',
)  # fmt: skip
PHASE_COLUMNS = (
    'phase', 'generation', 'evolving', 'predator_fitness', 'prey_fitness', 'retained',
    'episodes', 'ticks',
)  # fmt: skip
_FOLDERS = ('snapshots', 'checkpoint')
LOGS = {'generations': GENERATION_COLUMNS, 'phases': PHASE_COLUMNS}
_PACKAGES = ('numpy', 'numba')


class RunFolderError(ValueError):
    """A run folder cannot be used or written; one sentence that says why and what to do."""


def read_configuration(folder: Path | str) -> Configuration:
    """Read the configuration of the run in a folder.

    Raises
    ------
    RunFolderError
        No run there, or its run.json cannot be read.
    """
    return read_record(Path(folder) / 'run.json')[0]


def read_record(path: Path) -> tuple[Configuration, str]:
    """Read a run.json: the run's configuration, and what the user called it ('' without a name).

    Raises
    ------
    RunFolderError
        No such file, or it cannot be read.
    """
    try:
        content = read_run_json(path)
        with reading(path):
            configuration = load_configuration({**FIRST_RUNS, **content['configuration']})
            return configuration, str(content.get('condition', ''))
    except ReadingError as error:
        raise RunFolderError(str(error)) from None


def read_run_json(path: Path) -> dict[str, Any]:
    """Read all that a run.json tells.

    Raises
    ------
    ReadingError
        No such file, or it is damaged.
    """
    with reading(path):
        if not path.exists():
            raise ReadingError(f'{path.parent} holds no run: it has no run.json')
        content = parse_json(read_text(path))
        if not isinstance(content, dict):
            raise ValueError(f'it holds {reprlib.repr(content)}, expected an object')
        if content.get('version') != VERSION:
            raise ValueError(
                f'it has format version {reprlib.repr(content.get("version"))}, this program '
                f'reads {VERSION}'
            )
        for name in ('configuration', 'versions'):
            if not isinstance(content.get(name), dict):
                raise ValueError(
                    f'{name} is {reprlib.repr(content.get(name))}, expected names with values'
                )
    return content


def _never_began(path: Path) -> bool:
    """Whether this may be of a run that was killed before it had a run.json."""
    if path.name in _FOLDERS:
        return path.is_dir() and not any(path.iterdir())
    return path.name.endswith(TEMPORARY) or (path.name == 'run.log' and not path.stat().st_size)


def check_new_folder(path: Path | str) -> None:
    """Check that a run may begin in a folder: it is empty, or can be made.

    What a run leaves that was killed before it had a run.json does not count.

    Raises
    ------
    RunFolderError
    """
    path = Path(path)
    try:
        if (path / 'run.json').exists():
            raise RunFolderError(
                f'{path} holds another run; give another folder, or continue that run by '
                f'resuming {path}'
            )
        held = next(place for place in (path, *path.parents) if place.exists())
        if not held.is_dir():
            raise RunFolderError(f'cannot make {path}: {held} is not a folder')
        if not os.access(held, os.W_OK | os.X_OK):
            raise RunFolderError(f'cannot write {path}: no permission to write in {held}')
        if held == path and not all(map(_never_began, path.iterdir())):
            raise RunFolderError(f'{path} is not empty; give a new or an empty folder')
    except OSError as error:
        raise RunFolderError(f'cannot use {path}: {error.strerror}') from None


class RunFolder:
    """Writes the files of one run; one process at a time.

    Parameters
    ----------
    path : Path
        A folder made by `create`.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._writer = ThreadPoolExecutor(1)
        self._saving: Future[None] | None = None
        self._logs: dict[str, DurableLog] = {}
        self._snapshots: dict[int, bytes] = {}
        self._record = ''
        self._events_lock = threading.Lock()
        for name in (*_FOLDERS, 'run.log', *(f'{name}.csv' for name in LOGS)):
            if (path / name).is_symlink():
                raise RunFolderError(
                    f'{path / name} is a symbolic link, which a run does not write through'
                )
        with self._writing('run.log'):
            events = os.open(path / 'run.log', os.O_WRONLY | os.O_APPEND | OWN, 0o666)
            self._events = os.fdopen(events, 'a', encoding='utf-8')
            for name in _FOLDERS:
                (path / name).mkdir(exist_ok=True)
        try:
            fcntl.flock(self._events, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._events.close()
            raise RunFolderError(f'another process is running in {path}') from None

    @classmethod
    def create(cls, path: Path, configuration: Configuration, condition: str = '') -> RunFolder:
        """Start a run in a new or empty folder.

        Raises
        ------
        RunFolderError
        """
        check_new_folder(path)
        content = {
            'version': VERSION,
            **({'condition': condition} if condition else {}),
            'configuration': configuration.as_dict(),
            'versions': _versions(),
        }
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RunFolderError(f'cannot make {path}: {error.strerror}') from None
        folder = cls(path)
        try:
            if (path / 'run.json').exists():
                raise RunFolderError(f'another process began a run in {path}')
            folder._record = json.dumps(content, indent=2) + '\n'
            write_whole(path / 'run.json', folder._record.encode())
        except OSError as error:
            folder.close()
            folder._remove()
            raise RunFolderError(f'cannot write {path}: {error.strerror}') from None
        return folder

    def _remove(self) -> None:
        """Remove what there is of a run that could not begin."""
        with contextlib.suppress(OSError):
            (self.path / 'run.log').unlink()
            for name in _FOLDERS:
                (self.path / name).rmdir()
            self.path.rmdir()

    def restore(self, configuration: Configuration, algorithm: Algorithm) -> State | None:
        """Go back to the newest sound checkpoint; None when the run had not reached any.

        The logs are cut to where they were at that checkpoint. Damaged checkpoints are passed
        over, and said in run.log.

        Raises
        ------
        RunFolderError
            There are checkpoints, but none is sound.
        """
        try:
            self._record = read_text(self.path / 'run.json')
            sound = checkpoint.find_sound(self.path, configuration, algorithm, self.log)
        except ReadingError as error:
            raise RunFolderError(str(error)) from None
        with self._writing('leftovers'):
            for leftover in self.path.rglob('*' + TEMPORARY):
                leftover.unlink()
        if sound is None:
            self._open_logs(dict.fromkeys((*LOGS, *algorithm.journals), 0))
            return None
        state, seal = sound
        self._open_logs({name: seal.logs[name][0] for name in (*LOGS, *algorithm.journals)})
        self._snapshots = seal.snapshots
        checkpoint.drop_old(self.path / 'checkpoint')
        self.log(f'resumed after phase {state.phase}, generation {state.generation}')
        return state

    def save(
        self,
        configuration: Configuration,
        state: State,
        algorithm: Algorithm,
        generations: Iterable[GenerationStats],
        phase: PhaseStats,
        snapshot: bool,
    ) -> None:
        """Begin to put a completed phase on disk: logs, snapshot if wanted, checkpoint.

        It is written while the run goes on; that of the phase before is on disk by now.

        Raises
        ------
        RunFolderError
            That could not be written; the folder is as it was before it.
        """
        self.finish_saving()
        state, arrays, news = copy.deepcopy(state), algorithm.arrays(), algorithm.news()
        logged: dict[str, tuple[GenerationStats | PhaseStats, ...]] = {
            'generations': tuple(generations),
            'phases': (phase,),
        }

        wanted = self._wanted = threading.Event()

        def write() -> None:
            wanted.wait(HEAD_START)
            for name, rows in logged.items():
                with self._writing(f'{name}.csv'):
                    text = ''.join(_row(stats, LOGS[name]) for stats in rows)
                    self._logs[name].append(text.encode())
            for name, content in news.items():
                with self._writing(log_name(name)):
                    self._logs[name].append(content)
            if snapshot:
                self._save_snapshot(state)
            logs = {name: (log.size, log.sha256) for name, log in self._logs.items()}
            seal = Seal(logs, self._snapshots)
            with self._writing('checkpoint'):
                checkpoint.save(self.path / 'checkpoint', configuration, state, arrays, seal)

        self._saving = self._writer.submit(write)

    def finish_saving(self) -> None:
        """Wait until the last completed phase is on disk.

        Raises
        ------
        RunFolderError
            It could not be written; the folder is as it was after the phase before.
        """
        if self._saving is not None:
            saving, self._saving = self._saving, None
            self._wanted.set()
            saving.result()

    def _save_snapshot(self, state: State) -> None:
        name = snapshot_name(state.generation)
        arrays: dict[str, np.ndarray | np.generic] = {
            'version': np.int64(VERSION),
            'generation': np.int64(state.generation),
            'predators': state.predators,
            'prey': state.prey,
            'fitness': (state.fitness('predator') / state.pair_ticks).astype(np.float32),
            'run': np.array(self._record),
        }
        content = npz_bytes(arrays)
        with self._writing(name):
            write_whole(self.path / name, content)
        self._snapshots[state.generation] = hashlib.sha256(content).digest()

    def save_report(self, text: str) -> None:
        """Write report.md; RunFolderError when that fails."""
        with self._writing('report.md'):
            write_whole(self.path / 'report.md', text.encode())

    def log(self, message: str) -> None:
        """Add a line with the wall-clock time to run.log; from any thread.

        A line that finds no room is lost: the log says what happened, no result depends on it.
        """
        now = datetime.datetime.now().astimezone().isoformat(timespec='milliseconds')
        with self._events_lock, contextlib.suppress(OSError, ValueError):
            self._events.write(f'{now} {message}\n')
            self._events.flush()

    def close(self) -> None:
        """Close the files, when all is written, and let others use the folder."""
        self._writer.shutdown()
        for log in self._logs.values():
            log.close()
        with self._events_lock, contextlib.suppress(OSError):
            self._events.close()

    def _open_logs(self, sizes: dict[str, int]) -> None:
        with self._writing('logs'):
            for name, size in sizes.items():
                header = f'{",".join(LOGS[name])}\n'.encode() if name in LOGS else b''
                self._logs[name] = DurableLog(self.path / log_name(name), header, size)

    @contextlib.contextmanager
    def _writing(self, name: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise RunFolderError(
                f'cannot write {self.path / name}: {error.strerror}; every phase completed '
                f'before is safe, continue by resuming {self.path} once this is mended'
            ) from None


def _versions() -> dict[str, str]:
    """Return the versions of this program, Python and those packages that are installed."""
    versions = {'coevo_manager': __version__, 'python': platform.python_version()}
    if commit := source_commit():
        versions['commit'] = commit
    for name in _PACKAGES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    return versions


def _row(stats: GenerationStats | PhaseStats, columns: tuple[str, ...]) -> str:
    values = (getattr(stats, column) for column in columns)
    return ','.join(f'{v:.6f}' if isinstance(v, float) else str(v) for v in values) + '\n'

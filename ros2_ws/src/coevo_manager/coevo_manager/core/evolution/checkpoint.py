"""Checkpoints: everything a run needs to go on, in one .npz file (docs/formats.md)."""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithm import Algorithm
from coevo_manager.core.evolution.files import npz_bytes, write_whole
from coevo_manager.core.evolution.state import State

VERSION = 1
KEPT = 2
"""Checkpoints kept in a folder."""

_COUNTERS = ('phase', 'generation', 'episodes', 'ticks')
_ALGORITHM = 'algorithm_'


class CheckpointError(Exception):
    """A checkpoint cannot be used; one sentence that says why."""


def save(
    folder: Path,
    configuration: Configuration,
    state: State,
    algorithm: Algorithm,
    log_sizes: dict[str, int],
) -> None:
    """Write the checkpoint of a completed phase and drop all but the last two.

    Parameters
    ----------
    folder : Path
    configuration : Configuration
    state : State
    algorithm : Algorithm
    log_sizes : dict
        Sizes of the logs that belong to it, bytes, by name.

    Raises
    ------
    OSError
        Not written; older checkpoints are untouched.
    """
    arrays: dict[str, np.ndarray | np.generic] = {
        'version': np.int64(VERSION),
        'configuration': np.array(_identity(configuration)),
        'predators': state.predators,
        'prey': state.prey,
        'capture_ticks': state.capture_ticks,
        'evolving': np.array(state.evolving),
        **{name: np.int64(getattr(state, name)) for name in _COUNTERS},
        **{f'{name}_size': np.int64(size) for name, size in log_sizes.items()},
        **{_ALGORITHM + name: array for name, array in algorithm.arrays().items()},
    }
    arrays['sha256'] = np.array(_digest(arrays))
    write_whole(folder / f'phase_{state.phase:06d}.npz', npz_bytes(arrays))
    drop_old(folder)


def drop_old(folder: Path) -> None:
    """Drop all but the last two checkpoints."""
    for old in newest_first(folder)[KEPT:]:
        old.unlink()


def newest_first(folder: Path) -> list[Path]:
    """List the checkpoints in a folder."""
    paths = folder.glob('phase_*.npz')
    return sorted(paths, key=lambda path: (len(path.name), path.name), reverse=True)


def load(
    path: Path, configuration: Configuration, algorithm: Algorithm, logs: tuple[str, ...]
) -> tuple[State, dict[str, int]]:
    """Read a checkpoint.

    Parameters
    ----------
    path : Path
    configuration : Configuration
        The run's; a checkpoint of another one is refused.
    algorithm : Algorithm
        Gets back its arrays.
    logs : tuple of str
        Names of the logs.

    Returns
    -------
    State, log sizes by name

    Raises
    ------
    CheckpointError
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, NotImplementedError):
        raise CheckpointError(f'{path} is damaged') from None
    digest = arrays.pop('sha256', None)
    if digest is None or str(digest) != _digest(arrays):
        raise CheckpointError(f'{path} is damaged: its checksum does not match')
    if arrays['version'] != VERSION:
        raise CheckpointError(
            f'{path} has format version {arrays["version"]}, this program reads {VERSION}'
        )
    if str(arrays['configuration']) != _identity(configuration):
        raise CheckpointError(f'{path} belongs to a run of another configuration')
    state = State(
        arrays['predators'],
        arrays['prey'],
        arrays['capture_ticks'],
        configuration.episode_ticks,
        str(arrays['evolving']),
        *(int(arrays[name]) for name in _COUNTERS),
    )
    algorithm.restore(
        {
            name.removeprefix(_ALGORITHM): array
            for name, array in arrays.items()
            if name.startswith(_ALGORITHM)
        }
    )
    return state, {name: int(arrays[f'{name}_size']) for name in logs}


def _identity(configuration: Configuration) -> str:
    return json.dumps(configuration.as_dict())


def _digest(arrays: Mapping[str, np.ndarray | np.generic]) -> str:
    """SHA-256 over every array's name, type, shape and content."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f'{name} {array.dtype.str} {array.shape}\n'.encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()

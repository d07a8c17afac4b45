"""Checkpoints: everything a run needs to go on, in one .npz file (docs/formats.md)."""

from __future__ import annotations

import hashlib
import json
import reprlib
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from coevo_manager.core.configuration import FIELDS, Configuration
from coevo_manager.core.evolution.algorithm import Algorithm
from coevo_manager.core.evolution.files import npz_bytes, write_whole
from coevo_manager.core.evolution.loading import memory_size
from coevo_manager.core.evolution.seal import Seal, log_name
from coevo_manager.core.evolution.state import State
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import check_genomes
from neuro_controller.core.reading import (
    ReadingError,
    opened,
    parse_json,
    read_arrays,
    reading,
)
from neuro_controller.core.settings import FIRST_RUNS

VERSION = 3
KEPT = 2
"""Checkpoints kept in a folder."""

_COUNTERS = ('phase', 'generation', 'episodes', 'ticks')
_ALGORITHM = 'algorithm_'


class OtherRunError(ReadingError):
    """A checkpoint that is sound belongs to a run of another configuration."""


def save(
    folder: Path,
    configuration: Configuration,
    state: State,
    algorithm: Mapping[str, np.ndarray],
    seal: Seal,
) -> None:
    """Write the checkpoint of a completed phase and drop all but the last two.

    Parameters
    ----------
    folder : Path
    configuration : Configuration
    state : State
    algorithm : mapping
        The algorithm's arrays.
    seal : Seal
        Of the logs, journals and snapshots that belong to it.

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
        **{f'{species}_memory': state.memory[species] for species in SPECIES},
        **{name: np.int64(getattr(state, name)) for name in _COUNTERS},
        **seal.arrays(),
        **{_ALGORITHM + name: array for name, array in algorithm.items()},
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


def load(path: Path, configuration: Configuration) -> tuple[State, Seal, dict[str, np.ndarray]]:
    """Read a checkpoint.

    Parameters
    ----------
    path : Path
    configuration : Configuration
        The run's; a checkpoint of another one is refused.

    Returns
    -------
    State, Seal, and the algorithm's arrays

    Raises
    ------
    ReadingError
        It is damaged or of another run; the seal is not compared with the files.
    """
    arrays = read_arrays(path)
    with reading(path):
        if arrays['version'] != VERSION:
            raise ReadingError(
                f'{path} has format version {arrays["version"]}, this program reads {VERSION}'
            )
        if str(arrays.pop('sha256')) != _digest(arrays):
            raise ValueError('its checksum does not match')
        if not _belongs(str(arrays['configuration']), configuration):
            raise OtherRunError(f'{path} belongs to a run of another configuration')
        own = {
            name.removeprefix(_ALGORITHM): arrays.pop(name)
            for name in list(arrays)
            if name.startswith(_ALGORITHM)
        }
        return _state(arrays, configuration), Seal.of(arrays), own


def _state(arrays: Mapping[str, np.ndarray], configuration: Configuration) -> State:
    size, longest = configuration.population, configuration.pair_ticks
    layout = configuration.layout
    genomes = [check_genomes(arrays[name], name, layout) for name in ('predators', 'prey')]
    ticks, evolving = arrays['capture_ticks'], str(arrays['evolving'])
    if [len(population) for population in genomes] != [size, size]:
        raise ValueError(f'its populations are not of {size}')
    if ticks.shape != (size, size) or ticks.dtype != np.int32:
        raise ValueError(f'capture_ticks has shape {ticks.shape} of {ticks.dtype}')
    if ticks.min() < 1 or ticks.max() > longest:
        raise ValueError(f'capture_ticks does not lie in 1 to {longest}')
    if evolving not in SPECIES:
        raise ValueError(f'evolving is {reprlib.repr(evolving)}')
    counters = {name: int(arrays[name]) for name in _COUNTERS}
    if min(counters.values()) < 0:
        raise ValueError(f'one of {", ".join(_COUNTERS)} is negative')
    memory = {species: arrays[f'{species}_memory'] for species in SPECIES}
    wanted = (size, memory_size(configuration))
    for species, remembered in memory.items():
        if remembered.shape != wanted or remembered.dtype != np.float64:
            raise ValueError(f'{species}_memory has shape {remembered.shape}, expected {wanted}')
    return State(genomes[0], genomes[1], ticks, longest, evolving, **counters, memory=memory)


def find_sound(
    folder: Path,
    configuration: Configuration,
    algorithm: Algorithm,
    tell: Callable[[str], None] = lambda problem: None,
) -> tuple[State, Seal] | None:
    """Find the newest checkpoint that is sound, with all logs and snapshots that belong to it.

    Parameters
    ----------
    folder : Path
        The run folder.
    configuration : Configuration
        The run's.
    algorithm : Algorithm
        Gets back its arrays and journals.
    tell : callable
        Told of each checkpoint that is passed over.

    Returns
    -------
    State and Seal, or None where the run had not reached a checkpoint.

    Raises
    ------
    ReadingError
        There are checkpoints, but none is sound.
    """
    problems: list[str] = []
    for path in newest_first(folder / 'checkpoint'):
        try:
            state, seal, arrays = load(path, configuration)
            seal.check(folder)
            with reading(path):
                algorithm.restore(arrays, _journals(folder, algorithm, seal))
            return state, seal
        except ReadingError as error:
            tell(f'{error}; trying the checkpoint before {path.name}')
            if str(error) not in problems:
                problems.append(str(error))
    if problems:
        raise ReadingError(f'{folder} cannot go on: {"; ".join(problems)}')
    return None


def _journals(folder: Path, algorithm: Algorithm, seal: Seal) -> dict[str, np.ndarray]:
    """Read what a seal has found sound of an algorithm's journals."""
    journals = {}
    for name, kind in algorithm.journals.items():
        if name not in seal.logs:
            raise ValueError(f'it lacks {name!r}')
        with opened(folder / log_name(name)) as file:
            journals[name] = np.frombuffer(file.read(seal.logs[name][0]), kind)
    return journals


def check_content(folder: Path, configuration: Configuration) -> None:
    """Compare a run's files with what its newest readable checkpoint vouches for.

    Raises
    ------
    ReadingError
        One of them is not what the run wrote, or the checkpoint is of another run.
    """
    for path in newest_first(folder / 'checkpoint'):
        try:
            _, seal, _ = load(path, configuration)
        except OtherRunError:
            raise
        except ReadingError:
            continue
        seal.check(folder)
        return


def _identity(configuration: Configuration) -> str:
    return json.dumps(configuration.as_dict())


def _belongs(identity: str, configuration: Configuration) -> bool:
    """Whether that is a configuration's identity, or was before fields were added to it."""
    before = {name: option.default for name, option in FIELDS.items()} | FIRST_RUNS
    return {**before, **parse_json(identity)} == configuration.as_dict()


def _digest(arrays: Mapping[str, np.ndarray | np.generic]) -> str:
    """SHA-256 over every array's name, type, shape and content."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f'{name} {array.dtype.str} {array.shape}\n'.encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()

"""What a checkpoint vouches for: the content of a run folder's logs and snapshots."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from neuro_controller.core.reading import ARRAYS_LIMIT, opened, reading

LOGS = ('generations', 'phases')
"""Names of a run's logs, without their suffix."""


def log_name(name: str) -> str:
    """Return the file of a log, or of a journal of the algorithm."""
    return f'{name}.csv' if name in LOGS else f'{name}.bin'


@dataclass
class Seal:
    """Sizes and SHA-256 of files.

    Attributes
    ----------
    logs : dict of str to (int, bytes)
        How many bytes of each log and journal belong to the run, and their hash.
    snapshots : dict of int to bytes
        The hash of each snapshot, by its generation.
    """

    logs: dict[str, tuple[int, bytes]]
    snapshots: dict[int, bytes] = field(default_factory=dict)

    def arrays(self) -> dict[str, np.ndarray | np.generic]:
        """Return this as arrays of a checkpoint (docs/formats.md)."""
        hashes = b''.join(self.snapshots.values())
        arrays: dict[str, np.ndarray | np.generic] = {
            'snapshots': np.array(list(self.snapshots), np.int64),
            'snapshots_sha256': np.frombuffer(hashes, np.uint8).reshape(-1, 32),
        }
        for name, (size, digest) in self.logs.items():
            arrays[f'{name}_size'] = np.int64(size)
            arrays[f'{name}_sha256'] = np.frombuffer(digest, np.uint8)
        return arrays

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Seal:
        """Return the seal in a checkpoint's arrays."""
        generations, hashes = arrays['snapshots'].tolist(), arrays['snapshots_sha256']
        sizes = [name for name in arrays if name.endswith('_size')]
        names = {*LOGS, *(name.removesuffix('_size') for name in sizes)}
        return cls(
            {
                name: (int(arrays[f'{name}_size']), arrays[f'{name}_sha256'].tobytes())
                for name in sorted(names)
            },
            {g: row.tobytes() for g, row in zip(generations, hashes, strict=True)},
        )

    def check(self, folder: Path) -> None:
        """Compare the files of a run folder with this.

        Raises
        ------
        ReadingError
            One of them is missing, or is not what the run wrote.
        """
        for name, (size, digest) in self.logs.items():
            _check(folder / log_name(name), size, digest)
        for generation, digest in self.snapshots.items():
            _check(folder / snapshot_name(generation), None, digest)


def snapshot_name(generation: int) -> str:
    """Return the name of a snapshot within its run folder."""
    return f'snapshots/gen_{generation:06d}.npz'


def _check(path: Path, size: int | None, digest: bytes) -> None:
    with reading(path), opened(path) as file:
        content = file.read(ARRAYS_LIMIT if size is None else size)
        if size is not None and len(content) < size:
            raise ValueError(f'it has {len(content)} bytes, the run wrote {size}')
        if hashlib.sha256(content).digest() != digest:
            part = 'it is' if size is None else f'its first {size} bytes are'
            raise ValueError(f'{part} not what the run wrote')

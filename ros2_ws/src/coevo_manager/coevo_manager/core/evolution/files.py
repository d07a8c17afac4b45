"""Files that are whole or absent, whatever happens while they are written."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import secrets
from collections.abc import Mapping
from pathlib import Path

import numpy as np

TEMPORARY = '.partial'
"""Suffix of a file being written."""

OWN = os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
"""Flags that open a file of ours: no link of its name is followed, no pipe waited for."""


def write_whole(path: Path, content: bytes, durable: bool = True) -> None:
    """Write beside, flush to the disk and rename; a link is replaced, not followed.

    Without `durable` nothing is flushed: after a power cut the file may be empty.

    Raises
    ------
    OSError
        The file, which it names, was not written; what stood under this name still does.
    """
    beside = path.with_name(f'{path.name}.{secrets.token_hex(4)}{TEMPORARY}')
    try:
        with os.fdopen(os.open(beside, os.O_WRONLY | os.O_EXCL | OWN, 0o666), 'wb') as file:
            file.write(content)
            file.flush()
            if durable:
                os.fsync(file.fileno())
        beside.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise OSError(error.errno, error.strerror, str(path)) from None
    if not durable:
        return
    directory = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(directory)
    finally:
        os.close(directory)


def npz_bytes(arrays: Mapping[str, np.ndarray | np.generic]) -> bytes:
    """Return the content of an uncompressed .npz file; equal arrays give equal bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


class DurableLog:
    """A file that grows by whole blocks.

    Parameters
    ----------
    path : Path
    header : bytes
        What it begins with, written when the file is new or cut to nothing.
    size : int
        Bytes to keep of an existing file, which has as many; the rest is cut.
    """

    def __init__(self, path: Path, header: bytes, size: int) -> None:
        self._descriptor = os.open(path, os.O_RDWR | OWN, 0o666)
        os.ftruncate(self._descriptor, size)
        self.size = size
        self._hash = hashlib.sha256(os.pread(self._descriptor, size, 0))
        if not size:
            self.append(header)

    def append(self, content: bytes) -> None:
        """Add content and flush it to the disk; an OSError leaves the file as it was."""
        if not content:
            return
        try:
            written = 0
            while written < len(content):
                written += os.pwrite(self._descriptor, content[written:], self.size + written)
            os.fsync(self._descriptor)
        except OSError:
            os.ftruncate(self._descriptor, self.size)
            raise
        self.size += len(content)
        self._hash.update(content)

    @property
    def sha256(self) -> bytes:
        """Hash of what it holds."""
        return self._hash.digest()

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

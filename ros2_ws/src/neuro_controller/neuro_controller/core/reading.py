"""Reading files that may be damaged or made to do harm: one guard, and limits on what they ask."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import stat
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

ARRAYS_LIMIT = 2**26
"""Bytes that an array may have: five times those of the largest snapshot."""

TEXT_LIMIT = 2**18
"""Bytes of a text written by hand."""

_HEADER_LIMIT = 2**10
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


class ReadingError(ValueError):
    """A file cannot be used; one sentence that says which, what is wrong and where."""


@contextlib.contextmanager
def reading(path: Path | str) -> Iterator[None]:
    """Guard a reader: whatever its file makes it raise becomes a `ReadingError`."""
    try:
        yield
    except ReadingError:
        raise
    except OSError as error:
        raise ReadingError(f'{path} cannot be read: {error.strerror or error}') from None
    except Exception as error:
        reason = f'it lacks {error}' if isinstance(error, KeyError) else str(error)
        reason = ' '.join(reason.split()) or type(error).__name__
        raise ReadingError(f'{path} is damaged: {reason[:300]}') from None


@contextlib.contextmanager
def opened(path: Path | str) -> Iterator[BinaryIO]:
    """Open a file; a named pipe that nobody writes to is empty, and not waited for.

    Raises
    ------
    OSError
        It cannot be opened, or is a device, which may have no end.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    os.set_blocking(descriptor, True)
    with os.fdopen(descriptor, 'rb') as file:
        if stat.S_ISCHR(os.fstat(descriptor).st_mode):
            raise OSError(errno.ENODEV, 'Is a device', str(path))
        yield file


def read_bytes(path: Path | str, limit: int) -> bytes:
    """Return what a file holds.

    Raises
    ------
    ReadingError
        It cannot be read, or has more than `limit` bytes.
    """
    with reading(path), opened(path) as file:
        content = file.read(limit + 1)
        if len(content) > limit:
            raise ValueError(f'it has more than {limit} bytes')
        return content


def read_text(path: Path | str, limit: int = TEXT_LIMIT) -> str:
    """Return what a UTF-8 file holds, see `read_bytes`."""
    content = read_bytes(path, limit)
    with reading(path):
        try:
            return content.decode('utf-8-sig')
        except UnicodeDecodeError as error:
            line = content.count(b'\n', 0, error.start) + 1
            raise ValueError(
                f'line {line}, byte 0x{content[error.start]:02x} is not UTF-8'
            ) from None


def parse_json(text: str) -> Any:
    """Return what a JSON text says; ValueError where it is none, or gives a key twice."""
    return json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f'it gives the key {twice[:60]!r} twice')
    return content


def _refuse_constant(text: str) -> None:
    raise ValueError(f'{text} is no number of JSON')


def read_arrays(
    path: Path | str, needed: Sequence[str] = (), limit: int = ARRAYS_LIMIT
) -> dict[str, np.ndarray]:
    """Read the arrays of an .npz file; their headers are checked before their data.

    Parameters
    ----------
    path : Path or str
    needed : sequence of str
        Arrays that it must have.
    limit : int
        Bytes that each may have; one that is compressed, at most `ARRAYS_LIMIT`.

    Raises
    ------
    ReadingError
        It is no such file or damaged, lacks an array, or has one that asks for too much memory or
        holds anything but numbers and text.
    """
    with reading(path), opened(path) as file, zipfile.ZipFile(file) as archive:
        members = {info.filename.removesuffix('.npy'): info for info in archive.infolist()}
        if len(members) < len(archive.infolist()):
            raise ValueError('it holds two arrays of one name')
        for name in needed:
            if name not in members:
                raise ValueError(f'it lacks the array {name}')
        return {name: _read_array(archive, members[name], limit) for name in members}


def _read_array(archive: zipfile.ZipFile, info: zipfile.ZipInfo, limit: int) -> np.ndarray:
    if info.compress_type == zipfile.ZIP_DEFLATED:
        limit = min(limit, ARRAYS_LIMIT)  # a small file must not become a large array
    elif info.compress_type != zipfile.ZIP_STORED:
        raise ValueError(f'{info.filename} is compressed in a way that NumPy does not use')
    with archive.open(info) as member:
        version = np.lib.format.read_magic(member)
        if version not in _HEADERS:
            raise ValueError(f'{info.filename} has the unknown format version {version}')
        shape, _, dtype = _HEADERS[version](member, max_header_size=_HEADER_LIMIT)
        if any(length < 0 for length in shape):
            raise ValueError(f'{info.filename} has the shape {shape}')
        size = math.prod(shape) * dtype.itemsize
        if dtype.kind not in 'biufU':
            raise ValueError(f'{info.filename} holds {dtype}, expected numbers or text')
        if member.tell() + size != info.file_size or size > limit:
            raise ValueError(
                f'{info.filename} says that it has {size} bytes of data, expected '
                f'{info.file_size - member.tell()} and at most {limit}'
            )
    with archive.open(info) as member:
        return np.lib.format.read_array(member, max_header_size=_HEADER_LIMIT)

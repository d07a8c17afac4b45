"""A disk that is full, as far as a process can tell."""

import contextlib
import resource
import signal
import sys
from collections.abc import Iterator

import pytest


@contextlib.contextmanager
def full_disk(size: int) -> Iterator[None]:
    """Let no file of this process, and of those that it starts, grow beyond a size in bytes.

    Python keeps no bytecode meanwhile: it would not notice that it wrote only a part of a file.
    """
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, 'dont_write_bytecode', True)
        patch.setenv('PYTHONDONTWRITEBYTECODE', '1')
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
            signal.signal(signal.SIGXFSZ, handler)

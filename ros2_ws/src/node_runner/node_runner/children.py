"""Processes that a process starts and ends again."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

END_TIMEOUT = 5.0
"""How long processes may take to end after SIGINT before they are killed, s."""

_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None)


def executable_path(package: str, executable: str) -> Path:
    """Return the path of a package's executable.

    Raises
    ------
    ValueError
        There is no such package or executable.
    """
    try:
        path = Path(get_package_prefix(package), 'lib', package, executable)
    except (PackageNotFoundError, ValueError):
        raise ValueError(f'package {package!r} was not found') from None
    if not os.access(path, os.X_OK):
        raise ValueError(f'package {package!r} has no executable {executable!r}')
    return path


def _end_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


class Children:
    """A group of processes with one end.

    They do not get the terminal's Ctrl-C, since their parent ends them; and should it be killed,
    the kernel ends them. To be used as a context manager.
    """

    def __init__(self) -> None:
        self._processes: list[subprocess.Popen] = []

    def __enter__(self) -> Children:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def start(
        self, package: str, executable: str, arguments: Iterable[object] = (), **options: Any
    ) -> subprocess.Popen:
        """Start an executable of a package; `options` are those of `subprocess.Popen`.

        Raises
        ------
        ValueError
            There is no such package or executable.
        """
        process = subprocess.Popen(
            [str(executable_path(package, executable)), *map(str, arguments)],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=_end_with_parent,
            **options,
        )
        self._processes.append(process)
        return process

    def ended(self) -> list[subprocess.Popen]:
        """Return the processes that have ended by themselves."""
        return [process for process in self._processes if process.poll() is not None]

    def end(self) -> None:
        """End those that still run, and wait for them."""
        for process in self._processes:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + END_TIMEOUT
        for process in self._processes:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

"""Processes that a process starts, and that never outlive it."""

from __future__ import annotations

import ctypes
import os
import reprlib
import signal
import subprocess
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

END_TIMEOUT = 5.0
"""How long processes may take to end after SIGTERM before they are killed, s."""

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
        raise ValueError(f'package {reprlib.repr(package)} was not found') from None
    if not os.access(path, os.X_OK):
        raise ValueError(
            f'package {reprlib.repr(package)} has no executable {reprlib.repr(executable)}'
        )
    return path


class Child(subprocess.Popen):
    """A process that ends with its parent, from its first instruction on.

    Should the parent be killed, the kernel sends SIGTERM. A process group of its own keeps the
    terminal's Ctrl-C away, since the parent ends its children; and in the parent's session, a
    group that loses its parent while it is stopped is woken by the kernel, and so gets the signal.

    Parameters
    ----------
    command : sequence
        Program and arguments.
    options
        As of `subprocess.Popen`.
    """

    def __init__(self, command: Sequence[Any], **options: Any) -> None:
        parent = os.getpid()

        def end_with_parent() -> None:
            _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:  # it ended before the kernel was asked
                os._exit(1)

        super().__init__(
            [str(part) for part in command],
            stdin=subprocess.DEVNULL,
            process_group=0,
            preexec_fn=end_with_parent,
            **options,
        )


def end_all(children: Iterable[Child], timeout: float = END_TIMEOUT) -> None:
    """End processes, stopped ones too, and wait for them; kill those that take too long.

    Parameters
    ----------
    children : iterable of Child
    timeout : float
        How long they may take, s.
    """
    children = list(children)
    for child in children:
        child.terminate()
        child.send_signal(signal.SIGCONT)
    deadline = time.monotonic() + timeout
    for child in children:
        try:
            child.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


class Children:
    """Executables of packages, with one end; to be used as a context manager."""

    def __init__(self) -> None:
        self._children: list[Child] = []

    def __enter__(self) -> Children:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def start(
        self, package: str, executable: str, arguments: Sequence[Any] = (), **options: Any
    ) -> Child:
        """Start an executable of a package; `options` are those of `Child`.

        Raises
        ------
        ValueError
            There is no such package or executable.
        """
        child = Child([executable_path(package, executable), *arguments], **options)
        self._children.append(child)
        return child

    def ended(self) -> list[Child]:
        """Return the processes that have ended by themselves."""
        return [child for child in self._children if child.poll() is not None]

    def end(self) -> None:
        """End those that still run, and wait for them."""
        end_all(self._children)

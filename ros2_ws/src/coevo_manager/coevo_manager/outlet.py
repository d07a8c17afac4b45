"""What is printed while work goes on: a reader that goes away must not end the work."""

import contextlib
import io
import os
import sys
from typing import Any, TextIO, cast

from rich.console import Console


class Outlet:
    """A text stream that takes what is printed, for as long as anybody reads it.

    When the reader has gone (``| head``) or the disk behind it is full, the rest is dropped.

    Parameters
    ----------
    stream : TextIO, optional
        Standard output without it.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stdout or io.StringIO()  # none where it was closed

    def write(self, text: str) -> int:
        """Print text."""
        try:
            self._stream.write(text)
        except OSError:
            self._drop()
        return len(text)

    def flush(self) -> None:
        """Hand over what was printed."""
        try:
            self._stream.flush()
        except OSError:
            self._drop()

    def _drop(self) -> None:
        """Send to nowhere what is printed from now on, and what the stream still holds."""
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def make_console(stream: TextIO | None = None) -> Console:
    """Return a console that prints to an `Outlet` of a stream, standard output without one."""
    return Console(file=cast(TextIO, Outlet(stream)))

"""What a run shows in a terminal, and what it prints into a pipe."""

from __future__ import annotations

import datetime
import math
import time
from typing import Protocol

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.markdown import Markdown
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution import GenerationStats
from coevo_manager.outlet import make_console
from coevo_manager.runs.status import Status

REFRESH_RATE = 4
"""Drawings a second."""

LINE_PERIOD = 2.0
"""Shortest time between two plain lines, s; the last phase has one in any case."""

SHORTEST_BAR = 8
"""A terminal that leaves the bar fewer columns shows none."""

_CENTURY = 3.15e9  # s


class Display(Protocol):
    """Shows a run to its user; a context manager."""

    def __enter__(self) -> Display: ...
    def __exit__(self, *_: object) -> None: ...

    def wait(self, what: str) -> None:
        """Show what the run waits for before it begins."""
        ...

    def status(self, status: Status) -> None:
        """Show where the run stands."""
        ...

    def event(self, message: str) -> None:
        """Show what happened."""
        ...

    def report(self, text: str) -> None:
        """Show the report."""
        ...


def make_display(
    configuration: Configuration, quiet: bool = False, console: Console | None = None
) -> Display:
    """Return a live display for a terminal, plain lines for anything else, or one that is mute."""
    console = console or make_console()
    if quiet:
        return QuietDisplay()
    kind = TerminalDisplay if console.is_terminal else PlainDisplay
    return kind(configuration, console)


class QuietDisplay:
    """Shows nothing; errors go to stderr without it."""

    def __enter__(self) -> QuietDisplay:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def wait(self, what: str) -> None:
        """Be silent."""

    def status(self, status: Status) -> None:
        """Be silent."""

    def event(self, message: str) -> None:
        """Be silent."""

    def report(self, text: str) -> None:
        """Be silent."""


class TerminalDisplay:
    """Two lines that stay at the bottom of the terminal, however narrow, with a moving clock."""

    def __init__(self, configuration: Configuration, console: Console) -> None:
        self._configuration = configuration
        self._console = console
        self._waiting = ''
        self._status: Status | None = None
        self._start = time.monotonic()
        self._live = Live(
            console=console, get_renderable=self._render, refresh_per_second=REFRESH_RATE
        )

    def __enter__(self) -> TerminalDisplay:
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()

    def wait(self, what: str) -> None:
        """Show it beside the clock until the first status."""
        self._waiting = what

    def status(self, status: Status) -> None:
        """Show where the run stands at the next drawing."""
        self._status = status

    def event(self, message: str) -> None:
        """Print a line above the two."""
        self._console.print(message, style='yellow', highlight=False, markup=False, soft_wrap=True)

    def report(self, text: str) -> None:
        """Print the report, formatted."""
        self._console.print(Markdown(text))

    def _render(self) -> RenderableType:
        width = self._console.width
        clock = _duration(time.monotonic() - self._start)
        if self._status is None:
            return Group(_line(f'{clock} {self._waiting}'))
        share = f'{self._status.stats.progress:4.0%} '
        times = ', '.join(filter(None, (f' {clock}', _time_left(self._status))))
        first = Table.grid()
        room = width - len(share) - len(times)
        if room >= SHORTEST_BAR:
            bar = ProgressBar(total=1.0, completed=self._status.stats.progress, width=room)
            first.add_row(_line(share), bar, _line(times))
        else:
            first.add_row(_line(share + times))
        parts = _describe(self._status, self._configuration)
        while len(parts) > 1 and len(', '.join(parts)) > width:
            parts.pop()
        return Group(first, _line(', '.join(parts)))


class PlainDisplay:
    """A line now and then."""

    def __init__(self, configuration: Configuration, console: Console) -> None:
        self._configuration = configuration
        self._file = console.file
        self._next = 0.0

    def __enter__(self) -> PlainDisplay:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def wait(self, what: str) -> None:
        """Print a line."""
        self.event(what)

    def status(self, status: Status) -> None:
        """Print where the run stands, every few seconds."""
        now = time.monotonic()
        if now >= self._next or status.stats.progress >= 1:
            self._next = now + LINE_PERIOD
            parts = [*_describe(status, self._configuration), _time_left(status)]
            self.event(', '.join(filter(None, parts)))

    def event(self, message: str) -> None:
        """Print a line."""
        print(message, file=self._file, flush=True)

    def report(self, text: str) -> None:
        """Print the report as it is."""
        self.event(f'\n{text}')


def _line(text: str) -> Text:
    return Text(text, no_wrap=True, overflow='ellipsis')


def _describe(status: Status, configuration: Configuration) -> list[str]:
    """Return what is known of a run, what matters most first."""
    stats = status.stats
    of = f'/{configuration.phases}' if configuration.phases is not None else ''
    parts = [f'phase {stats.phase}{of}', f'generation {stats.generation}']
    if isinstance(stats, GenerationStats):
        parts.append(f'{stats.evolving} evolving {stats.fitness_mean:.3f}')
    parts.append(f'all {stats.predator_fitness:.3f} : {stats.prey_fitness:.3f}')
    if status.ticks_per_second:
        parts.append(f'{status.ticks_per_second / 1e6:.1f} M ticks/s')
    return parts


def _time_left(status: Status) -> str:
    return '' if math.isnan(status.seconds_left) else f'{_duration(status.seconds_left)} left'


def _duration(seconds: float) -> str:
    if seconds >= _CENTURY:
        return 'more than a century'
    return str(datetime.timedelta(seconds=round(seconds)))

"""What a run shows in a terminal, and what it prints into a pipe."""

from __future__ import annotations

import datetime
import math
import time
from typing import Protocol

from rich.console import Console
from rich.markdown import Markdown
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution import GenerationStats
from coevo_manager.runs.run import Status

SCREEN_PERIOD = 0.25
"""Shortest time between two drawings, s."""

LINE_PERIOD = 2.0
"""Shortest time between two plain lines, s; the last phase has one in any case."""


class Display(Protocol):
    """Shows a run to its user; a context manager."""

    def __enter__(self) -> Display: ...
    def __exit__(self, *_) -> None: ...

    def status(self, status: Status) -> None:
        """Show where the run stands."""
        ...

    def event(self, message: str) -> None:
        """Show what happened."""
        ...

    def report(self, text: str) -> None:
        """Show the report."""
        ...


def make_display(configuration: Configuration, console: Console | None = None) -> Display:
    """Return a live display for a terminal, or plain lines for anything else."""
    console = console or Console()
    kind = TerminalDisplay if console.is_terminal else PlainDisplay
    return kind(configuration, console)


class TerminalDisplay:
    """A progress bar that stays at the bottom of the terminal."""

    def __init__(self, configuration: Configuration, console: Console) -> None:
        self._configuration = configuration
        self._console = console
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn('{task.description}'),
            BarColumn(),
            TextColumn('{task.percentage:>3.0f} %'),
            TimeElapsedColumn(),
            TextColumn('{task.fields[left]}'),
            console=console,
            auto_refresh=False,
        )
        self._task = self._progress.add_task('starting evaluators', total=1.0, left='')
        self._next = 0.0

    def __enter__(self) -> TerminalDisplay:
        self._progress.start()
        self._progress.refresh()
        return self

    def __exit__(self, *_) -> None:
        self._progress.refresh()
        self._progress.stop()

    def status(self, status: Status) -> None:
        """Draw where the run stands, a few times a second."""
        now = time.monotonic()
        if now < self._next and status.stats.progress < 1:
            return
        self._next = now + SCREEN_PERIOD
        self._progress.update(
            self._task,
            completed=status.stats.progress,
            description=_describe(status, self._configuration),
            left=_time_left(status),
            refresh=True,
        )

    def event(self, message: str) -> None:
        """Print a line above the bar."""
        self._progress.print(message, style='yellow', highlight=False, markup=False)

    def report(self, text: str) -> None:
        """Print the report, formatted."""
        self._console.print(Markdown(text))


class PlainDisplay:
    """A line now and then."""

    def __init__(self, configuration: Configuration, console: Console) -> None:
        self._configuration = configuration
        self._file = console.file
        self._next = 0.0

    def __enter__(self) -> PlainDisplay:
        return self

    def __exit__(self, *_) -> None:
        pass

    def status(self, status: Status) -> None:
        """Print where the run stands, every few seconds."""
        now = time.monotonic()
        if now >= self._next or status.stats.progress >= 1:
            self._next = now + LINE_PERIOD
            self.event(f'{_describe(status, self._configuration)} {_time_left(status)}'.rstrip())

    def event(self, message: str) -> None:
        """Print a line."""
        print(message, file=self._file, flush=True)

    def report(self, text: str) -> None:
        """Print the report as it is."""
        self.event(f'\n{text}')


def _describe(status: Status, configuration: Configuration) -> str:
    stats = status.stats
    of = f'/{configuration.phases}' if configuration.phases is not None else ''
    text = f'phase {stats.phase}{of}, generation {stats.generation}'
    if isinstance(stats, GenerationStats):
        text += f', evolving {stats.evolving} {stats.fitness_mean:.3f}'
    text += f', populations: predators {stats.predator_fitness:.3f} prey {stats.prey_fitness:.3f}'
    if status.ticks_per_second:
        text += f', {status.ticks_per_second / 1e6:.1f} M ticks/s'
    return text


def _time_left(status: Status) -> str:
    if math.isnan(status.seconds_left):
        return ''
    return f'{datetime.timedelta(seconds=round(status.seconds_left))} left'

"""Where a run stands, and the file in its folder that says so while it goes on."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from coevo_manager.core.evolution import GenerationStats, PhaseStats
from coevo_manager.core.evolution.files import write_whole

STATUS_PERIOD = 0.1
"""Shortest time between two generations that are told, s; the last of a phase always is."""

FILE_NAME = 'status.json'

FILE_PERIOD = 1.0
"""Shortest time between two writings of the file, s."""


@dataclasses.dataclass(frozen=True)
class Status:
    """Where a run stands.

    Attributes
    ----------
    stats : GenerationStats or PhaseStats
        What was completed last.
    ticks_per_second : float
        Simulated lately; 0 in the first `STATUS_PERIOD`.
    seconds_left : float
        Wall-clock time to the end at this pace; NaN while nothing is known of it.
    """

    stats: GenerationStats | PhaseStats
    ticks_per_second: float
    seconds_left: float


class Pace:
    """How fast a run goes on."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None
        self._last = (0.0, 0)
        self._rate = 0.0

    def status(self, stats: GenerationStats | PhaseStats, now: float) -> Status:
        """Return where the run stands after it told `stats` at the time `now`, s."""
        if self._first is None:
            self._first = now, stats.progress
            self._last = now, stats.ticks
        seconds = now - self._last[0]
        if seconds >= STATUS_PERIOD:
            rate = (stats.ticks - self._last[1]) / seconds
            self._rate = 0.8 * self._rate + 0.2 * rate if self._rate else rate
            self._last = now, stats.ticks
        spent = stats.progress - self._first[1]
        left = (1 - stats.progress) / spent * (now - self._first[0]) if spent > 0 else math.nan
        return Status(stats, self._rate, left)


class StatusFile:
    """``status.json`` of a run folder (docs/formats.md), written at most once a second.

    It is written beside and renamed, and not flushed to the disk: no result depends on it. What
    finds no room is lost.

    Parameters
    ----------
    folder : Path
        The run's.
    evaluators : callable, optional
        Returns what is known of the evaluators, for JSON.
    """

    def __init__(self, folder: Path, evaluators: Callable[[], dict[str, Any]] = dict) -> None:
        self._path = folder / FILE_NAME
        self._evaluators = evaluators
        self._next = 0.0

    def write(self, status: Status) -> None:
        """Write where the run stands, if that is due, or the run has spent its budget."""
        now = time.monotonic()
        if now < self._next and status.stats.progress < 1:
            return
        self._next = now + FILE_PERIOD
        left = status.seconds_left
        content = {
            'time': time.time(),
            'ticks_per_second': status.ticks_per_second,
            'seconds_left': None if math.isnan(left) else left,
            **dataclasses.asdict(status.stats),
            **self._evaluators(),
        }
        with contextlib.suppress(OSError):
            write_whole(self._path, json.dumps(content).encode(), durable=False)

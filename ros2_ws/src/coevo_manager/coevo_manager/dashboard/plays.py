"""Episodes that the page asks for, played by the kernel in this process."""

from __future__ import annotations

import threading
import time
from functools import lru_cache
from typing import Any

import numpy as np

from coevo_manager.analysis.report.packing import constants, pack
from coevo_manager.core.episodes import measure_pairs, trace_pairs
from coevo_manager.dashboard.charts import tournament_chart
from coevo_manager.dashboard.watched import NOW, WatchedRun
from neuro_controller.core.reading import ReadingError
from neuro_controller.core.snapshot import Snapshot

RANKS = ('best', 'median', 'worst')

BEST = 6
"""Individuals of each species, the best of a generation, that meet in the small tournament."""

COMPARED = 8
"""Generations that it compares at most."""

PATIENCE = 1.5
"""How long cells of it are played at a stretch, s."""

Cell = tuple[float, float, float]
"""Predator fitness, and complexity of predators and prey."""


def watch_view(run: WatchedRun) -> dict[str, Any]:
    """Return a run as `player.js` takes it; its episodes are played when they are chosen."""
    return {
        'key': run.key,
        'title': run.name,
        'generations': [NOW, *run.snapshots],
        'ranks': list(RANKS),
        **constants(run.environment),
    }


def individual(run: WatchedRun, species: str, generation: str, rank: str) -> np.ndarray:
    """Return a genome, float32 (genes,).

    Raises
    ------
    ReadingError
        The run has no such generation or rank.
    """
    if rank not in RANKS:
        raise ReadingError(f'rank is {rank[:20]!r}, expected one of {", ".join(RANKS)}')
    snapshot = run.snapshot(generation)
    ranking = snapshot.ranking(species)
    place = {'best': 0, 'median': len(ranking) // 2, 'worst': len(ranking) - 1}[rank]
    return snapshot.population(species)[ranking[place]]


class Plays:
    """Plays one request at a time, so that a run beside it keeps the cores."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._cells: dict[tuple[str, int, int], Cell] = {}
        self._snapshot = lru_cache(2 * COMPARED)(lambda run, generation: run.snapshot(generation))

    def episode(
        self, run: WatchedRun, predator: tuple[str, str], prey: tuple[str, str]
    ) -> dict[str, Any]:
        """Return the packed episode of two individuals, each a generation and a rank.

        Raises
        ------
        ReadingError
            There are none such.
        """
        predators = individual(run, 'predator', *predator)[None]
        opponents = individual(run, 'prey', *prey)[None]
        first = np.zeros(1, int)
        with self._lock:
            (trace,) = trace_pairs(predators, opponents, first, first, run.environment)
        return pack(trace)

    def tournament(self, run: WatchedRun) -> dict[str, Any]:
        """Play on at the small tournament of a run's snapshots.

        Returns
        -------
        dict
            Ready for JSON: the `chart`, and how many cells are `missing`; who asks again lets
            more be played.

        Raises
        ------
        ReadingError
            A snapshot is damaged.
        """
        every = list(run.snapshots)
        count = min(COMPARED, len(every))
        if not count:
            raise ReadingError(f'{run.name} has no snapshot yet')
        chosen = [every[k] for k in np.linspace(0, len(every) - 1, count).round().astype(int)]
        wanted = [(i, j) for i in chosen for j in chosen]
        wanted.sort(key=lambda pair: pair[0] != pair[1])  # contemporaries first
        deadline = time.monotonic() + PATIENCE
        for i, j in wanted:
            if (run.key, i, j) not in self._cells and time.monotonic() < deadline:
                self._cells[run.key, i, j] = self._play(run, i, j)
        unknown = (np.nan, np.nan, np.nan)
        table = np.array(
            [[self._cells.get((run.key, i, j), unknown) for j in chosen] for i in chosen]
        )
        diagonal = np.arange(count)
        return {
            'chart': tournament_chart(chosen, table[..., 0], table[diagonal, diagonal, 1:]),
            'missing': int(np.isnan(table[..., 0]).sum()),
        }

    def _play(self, run: WatchedRun, of_predators: int, of_prey: int) -> Cell:
        with self._lock:
            first: Snapshot = self._snapshot(run, str(of_predators))
            other: Snapshot = self._snapshot(run, str(of_prey))
            predators, prey = first.best('predator', BEST), other.best('prey', BEST)
            i, j = np.indices((len(predators), len(prey))).reshape(2, -1)
            ticks, complexity = measure_pairs(predators, prey, i, j, run.environment)
        fitness = 1 - ticks.mean() / run.environment.episode_ticks
        of_predator, of_prey = complexity.mean(axis=0)
        return float(fitness), float(of_predator), float(of_prey)

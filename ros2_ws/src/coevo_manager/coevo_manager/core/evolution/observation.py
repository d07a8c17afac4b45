"""What a running evolution tells its observer."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path


@dataclasses.dataclass(frozen=True, slots=True)
class GenerationStats:
    """One completed generation; a row of generations.csv, and where the run stands.

    Attributes
    ----------
    generation : int
        Generations completed, from 1.
    phase : int
        Running phase, from 1.
    evolving : str
        ``'predator'`` or ``'prey'``.
    fitness_mean, fitness_min, fitness_max : float
        Fitness of the n evolving agents after replacement, 0 to 1.
    accepted : int
        Agents that this generation improved or replaced.
    episodes, ticks : int
        Cost of the run up to here.
    predator_fitness, prey_fitness : float
        Means of the populations, N x N, at the start of this phase.
    progress : float
        Share of the run's budget spent, 0 to 1.
    """

    generation: int
    phase: int
    evolving: str
    fitness_mean: float
    fitness_min: float
    fitness_max: float
    accepted: int
    episodes: int
    ticks: int
    predator_fitness: float
    prey_fitness: float
    progress: float


@dataclasses.dataclass(frozen=True, slots=True)
class PhaseStats:
    """One completed phase, on disk by now; a row of phases.csv.

    Attributes
    ----------
    phase : int
        Phases completed; 0 after the first N x N evaluation.
    generation : int
        Generations completed.
    evolving : str
        Species that evolved in this phase; empty in phase 0.
    predator_fitness, prey_fitness : float
        Means of the populations, N x N, after the phase, 0 to 1.
    retained : int
        Evolved agents that stayed in the population.
    episodes, ticks : int
        Cost of the run up to here.
    progress : float
        Share of the run's budget spent, 0 to 1.
    """

    phase: int
    generation: int
    evolving: str
    predator_fitness: float
    prey_fitness: float
    retained: int
    episodes: int
    ticks: int
    progress: float


@dataclasses.dataclass(frozen=True, slots=True)
class Outcome:
    """How a call of run ended.

    Attributes
    ----------
    finished : bool
        False when it was stopped; the folder can be resumed.
    folder : Path
        The run folder.
    report : str
        The text of report.md; empty when stopped.
    """

    finished: bool
    folder: Path
    report: str


Observer = Callable[[GenerationStats | PhaseStats], None]
"""Called in the thread that runs the evolution; it should return quickly."""

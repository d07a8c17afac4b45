"""Who meets whom in a phase, and what comes of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

Draw = Callable[[int, int, int], np.ndarray]
"""(agent, generation of the phase from 0, groups of candidates) -> int (groups, m): the opponents
that each group meets, by their index."""


@dataclasses.dataclass(frozen=True)
class Opponents:
    """The opponents of a phase.

    Attributes
    ----------
    genomes : float32 (m, genes)
    index : int (m,), optional
        Their places in the opposing population, whose results are known; None when they come
        from elsewhere.
    draw : callable, optional
        What chooses some of them for each generation; without it everyone meets all.
    met : int, optional
        How many of them a candidate meets, where they are drawn.
    """

    genomes: np.ndarray
    index: np.ndarray | None = None
    draw: Draw | None = None
    met: int | None = None

    @property
    def number(self) -> int:
        """How many opponents a candidate meets."""
        return len(self.genomes) if self.met is None else self.met


@dataclasses.dataclass(frozen=True)
class Agents:
    """Those that evolve in a phase, as they begin.

    Attributes
    ----------
    genomes : float32 (n, genes)
    training : int64 (n,)
        Fitness summed over the phase's opponents, in ticks; zeros where it is unknown.
    memory : float64 (n, size)
        What their optimizers remember.
    places : int64 (n,), optional
        Their places in the population, where they come from it.
    """

    genomes: np.ndarray
    training: np.ndarray
    memory: np.ndarray
    places: np.ndarray | None = None


@dataclasses.dataclass(frozen=True)
class Meeting:
    """One generation of one agent against opponents drawn for it.

    Attributes
    ----------
    genome : float32 (genes,)
        The agent after it.
    opponents : int (k, m)
        Whom each candidate met.
    capture_ticks : int32 (k, m)
    """

    genome: np.ndarray
    opponents: np.ndarray
    capture_ticks: np.ndarray


@dataclasses.dataclass(frozen=True)
class Evolved:
    """What a phase has made of its agents.

    Attributes
    ----------
    genomes : float32 (n, genes)
    training : int64 (n,)
        Their fitness summed over the opponents, in ticks.
    capture_ticks : int32 (n, rivals)
        Of their episodes against the rivals.
    memory : float64 (n, size)
        What their optimizers remember.
    positions : float32 (n, genes)
        Where their optimizers would go on.
    meetings : list of list of Meeting
        Of each agent, in order, where opponents were drawn for each generation.
    """

    genomes: np.ndarray
    training: np.ndarray
    capture_ticks: np.ndarray
    memory: np.ndarray
    positions: np.ndarray
    meetings: list[list[Meeting]]

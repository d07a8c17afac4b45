"""Chases as pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.trace import Trace

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from coevo_manager.recording.drawing import Track


def plot_chase(trace: Trace, environment: Environment = Environment()) -> Figure:
    """Draw both robots' paths, with their starts (hollow) and ends.

    Parameters
    ----------
    trace : Trace
        From `trace_pair` or `trace_pairs`.
    environment : Environment
        Where it was played.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it; its ``savefig`` writes it.

    Examples
    --------
    >>> import red_queen as rq
    >>> hunter, hunted = (
    ...     rq.select_champion('shipped/open', species).genome for species in rq.SPECIES
    ... )
    >>> rq.plot_chase(rq.trace_pair(hunter, hunted)).savefig('chase.png')
    """
    from coevo_manager.recording.drawing import trajectories

    return trajectories(_track(trace, environment))


def animate_chase(
    trace: Trace, path: Path | str, environment: Environment = Environment(), rate: float = 1.0
) -> None:
    """Write a chase as an animated GIF.

    Parameters
    ----------
    trace : Trace
        From `trace_pair` or `trace_pairs`.
    path : Path or str
        The file to write.
    environment : Environment
        Where it was played.
    rate : float
        Speed, times real time.

    Examples
    --------
    >>> import red_queen as rq
    >>> hunter, hunted = (
    ...     rq.select_champion('shipped/open', species).genome for species in rq.SPECIES
    ... )
    >>> rq.animate_chase(rq.trace_pair(hunter, hunted), 'chase.gif', rate=20)
    """
    from coevo_manager.core.evolution.files import write_whole
    from coevo_manager.recording.animation import Pace, make_gif

    track = _track(trace, environment)
    write_whole(Path(path), make_gif(track, Pace.of(track, rate)))


def _track(trace: Trace, environment: Environment) -> Track:
    from coevo_manager.recording.drawing import Track

    return Track(trace.poses, environment.arena.size, environment.obstacle, trace.captured)

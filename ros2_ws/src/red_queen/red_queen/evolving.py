"""Evolution in the calling process, without ROS."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from coevo_manager.core.evolution import (
    Evolution,
    Observer,
    Outcome,
    load_configuration,
    read_configuration,
)
from coevo_manager.core.local_evaluator import LocalEvaluator


def evolve(
    run_folder: Path | str,
    observer: Observer | None = None,
    threads: int | None = None,
    preset: str = 'quick',
    **settings: Any,
) -> Outcome:
    """Evolve predators and prey into a run folder, which the commands read as well.

    Interrupted (Ctrl-C, a notebook's stop button), it leaves a folder that `resume` goes on with.
    The files are those of the command ``evolve`` with the same settings, byte for byte.

    Parameters
    ----------
    run_folder : Path or str
        Folder to create; an existing one must be empty.
    observer : callable, optional
        Called with `GenerationStats` after each generation and with `PhaseStats` after each phase;
        their ``progress`` goes from 0 to 1.
    threads : int, optional
        Threads to play in, one for each core without it; they change no result.
    preset : str
        'quick' or 'paper': what the settings change.
    **settings
        Fields of `Configuration`: algorithm, seed, world, population, phases and so on, as
        ``evolve --help`` lists them.

    Returns
    -------
    Outcome
        How it ended; its ``report`` is the text of report.md.

    Raises
    ------
    ValueError
        An unknown setting, a value out of its range, or settings that do not go together.
    RunFolderError
        The folder holds something already, or cannot be written.

    Examples
    --------
    >>> import red_queen as rq
    >>> shares = []
    >>> outcome = rq.evolve(
    ...     'runs/example',
    ...     observer=lambda stats: shares.append(stats.progress),
    ...     population=8, selected=2, generations=5, phases=4, swap_generations=10,
    ...     snapshot_generations=10,
    ... )
    >>> outcome.finished, shares[-1]
    (True, 1.0)
    """
    configuration = load_configuration(settings, preset)
    evaluator = _make_evaluator(configuration.make_environment(), threads)
    try:
        return Evolution(configuration, evaluator, run_folder, observer).run()
    finally:
        evaluator.close()


def resume(
    run_folder: Path | str, observer: Observer | None = None, threads: int | None = None
) -> Outcome:
    """Go on with a run that ended before its budget, to the files it would have had anyway.

    Parameters
    ----------
    run_folder, observer, threads
        As for `evolve`.

    Raises
    ------
    RunFolderError
        There is no run, it is in use, or none of its checkpoints is sound.

    Examples
    --------
    >>> import red_queen as rq
    >>> rq.resume('runs/mine').finished
    True
    """
    evaluator = _make_evaluator(read_configuration(run_folder).make_environment(), threads)
    try:
        return Evolution.resume(run_folder, evaluator, observer).run()
    finally:
        evaluator.close()


def _make_evaluator(environment: Any, threads: int | None) -> LocalEvaluator:
    return LocalEvaluator(environment, threads or len(os.sched_getaffinity(0)))

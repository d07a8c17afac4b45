"""A whole run: phases of evolution, kept in a run folder."""

from __future__ import annotations

import threading
from pathlib import Path

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evaluation import Evaluator
from coevo_manager.core.evolution.observation import Observer, Outcome


class Evolution:
    """One run of co-evolution, repeatable and durable.

    Parameters
    ----------
    configuration : Configuration
        Everything that decides the results; the files of two runs of it are equal byte for byte
        (but run.log), whatever the evaluator's speed, number of slots and order of answers.
    evaluator : Evaluator
        Plays the episodes; it stays the caller's to close.
    run_folder : Path or str
        Folder to create; an existing one must be empty.
    observer : Observer, optional
        Called with `GenerationStats` after each generation, and with `PhaseStats` after the
        checkpoint of each phase.

    Raises
    ------
    RunFolderError
        The folder holds something already, or cannot be written.
    ValueError
        The evaluator's environment is not the configuration's.
    """

    def __init__(
        self,
        configuration: Configuration,
        evaluator: Evaluator,
        run_folder: Path | str,
        observer: Observer | None = None,
    ) -> None:
        self.configuration = configuration
        self._evaluator = evaluator
        self._folder = Path(run_folder)
        self._observer = observer
        self._stop = threading.Event()

    @classmethod
    def resume(
        cls,
        run_folder: Path | str,
        evaluator: Evaluator,
        observer: Observer | None = None,
        configuration: Configuration | None = None,
    ) -> Evolution:
        """Go on with a run that ended before its budget, from its newest sound checkpoint.

        The evaluator's environment must be that of ``read_configuration(run_folder)``. With
        ``configuration`` given, a folder of another one is refused, naming the difference.

        Raises
        ------
        RunFolderError
            No run there, another configuration's, no sound checkpoint, or in use.
        """
        raise NotImplementedError

    def run(self) -> Outcome:
        """Evolve till the budget is spent or `stop` is called, and write the report.

        Raises
        ------
        RunFolderError
            The folder cannot be written (a full disk). What it holds stays valid: resume it.
        """
        raise NotImplementedError

    def stop(self) -> None:
        """Ask the run to end within a generation; from any thread or a signal handler.

        The folder stays valid and `resume` continues it as if it had never stopped.
        """
        self._stop.set()

    def log(self, message: str) -> None:
        """Add a line with the wall-clock time to run.log; from any thread."""
        raise NotImplementedError

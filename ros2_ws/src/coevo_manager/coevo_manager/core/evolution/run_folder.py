"""The folder of a run: configuration, logs, snapshots, checkpoints, report."""

from __future__ import annotations

import json
from pathlib import Path

from coevo_manager.core.configuration import Configuration, load_configuration


class RunFolderError(Exception):
    """A run folder cannot be used or written; one sentence that says why and what to do."""


def read_configuration(folder: Path | str) -> Configuration:
    """The configuration of the run in a folder.

    Raises
    ------
    RunFolderError
        No run there, or its run.json cannot be read.
    """
    path = Path(folder) / 'run.json'
    try:
        return load_configuration(json.loads(path.read_text())['configuration'])
    except FileNotFoundError:
        raise RunFolderError(f'{folder} holds no run: it has no run.json') from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RunFolderError(f'{path} cannot be read: {error}') from None

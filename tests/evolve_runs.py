"""Toy runs of evolve for tests, and what tests ask of them."""

from pathlib import Path

import psutil

from coevo_manager.core.evolution import Evolution
from coevo_manager.core.local_evaluator import LocalEvaluator
from coevo_manager.runs.options import read_options
from coevo_manager.runs.run import make_plan

TOY = (
    *('--population', '16', '--selected', '4', '--generations', '10', '--phases', '30'),
    *('--swap-generations', '50', '--snapshot-generations', '150', '--episode-ticks', '400'),
)
"""Options of a run that takes a second or two."""


def read_files(folder: Path) -> dict[str, bytes]:
    """Every file of a run folder that equal runs have in common, by name."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob('*'))
        if path.is_file() and path.name not in ('run.log', 'sessions.json', 'status.json')
    }


def toy_files(folder: Path, *changes: str) -> dict[str, bytes]:
    """The files of the toy run with other options, played in this process."""
    options = read_options([*TOY, *changes])
    configuration = make_plan(options.values, options.preset, folder, None).configuration
    Evolution(configuration, LocalEvaluator(configuration.make_environment()), folder).run()
    return read_files(folder)


def phases_completed(folder: Path) -> int:
    """Phases on disk; 0 before the run begins."""
    path = folder / 'phases.csv'
    return max(path.read_text().count('\n') - 2, 0) if path.exists() else 0


def evaluators_of(pid: int) -> list[psutil.Process]:
    """The evaluator processes that a process started, oldest first."""
    children = psutil.Process(pid).children(recursive=True)
    return sorted(
        (child for child in children if 'coevo_manager.evaluators.evaluator' in child.cmdline()),
        key=lambda child: child.create_time(),
    )

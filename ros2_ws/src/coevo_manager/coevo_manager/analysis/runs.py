"""Read run folders and group them: replications of conditions, conditions within environments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coevo_manager.analysis.conditions import Condition, assign, order
from coevo_manager.analysis.logs import read_columns
from coevo_manager.core.configuration import Configuration
from coevo_manager.core.episodes import Environment
from coevo_manager.core.evolution.checkpoint import check_content
from coevo_manager.core.evolution.run_folder import LOGS, read_record, read_run_json
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import check_genomes
from neuro_controller.core.snapshot import Snapshot, read_snapshot, snapshots

if TYPE_CHECKING:
    import pandas as pd

POINTS = 15  # as the paper: 150,000 generations looked at every 10,000


class AnalysisError(ValueError):
    """The runs cannot be analysed; one sentence that says why."""


@dataclass(frozen=True)
class Replication:
    """A run folder: one replication.

    Attributes
    ----------
    folder : Path
    configuration : Configuration
    named : str
        What a campaign called its condition; '' where none did.
    condition : Condition
        What it is a replication of.
    snapshots : dict of int to Path
        By generation.
    """

    folder: Path
    configuration: Configuration
    named: str
    condition: Condition
    snapshots: dict[int, Path]

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.folder.resolve().name

    @property
    def seed(self) -> int:
        """Seed, which tells replications apart."""
        return self.configuration.seed

    @cached_property
    def environment(self) -> Environment:
        """Where the episodes of the analysis are played: each pair plays once."""
        return replace(self.configuration.make_environment(), repetitions=1)

    @cached_property
    def versions(self) -> str:
        """What it was evolved with, as its run.json tells."""
        versions = read_run_json(self.folder / 'run.json')['versions']
        return ', '.join(f'{name} {value}' for name, value in versions.items())

    @cached_property
    def never_evolved(self) -> tuple[str, ...]:
        """The species that did not evolve for a single phase."""
        evolved = set(self.columns('phases')['evolving'])
        return tuple(species for species in SPECIES if species not in evolved)

    def snapshot(self, generation: int) -> Snapshot:
        """Read and check one snapshot.

        Raises
        ------
        AnalysisError, ReadingError
            It is missing, damaged, or does not hold what a snapshot holds.
        """
        if generation not in self.snapshots:
            raise AnalysisError(
                f'{self.folder}: the snapshot of generation {generation} is missing'
            )
        path = self.snapshots[generation]
        snapshot = read_snapshot(path)
        size = self.configuration.population
        found = snapshot.fitness.shape
        check_genomes(snapshot.predators, f'predators of {path}', self.configuration.layout)
        if snapshot.generation != generation or found != (size, size):
            raise AnalysisError(
                f'{path} should hold generation {generation} of {size} predators and {size} prey, '
                f'but holds generation {snapshot.generation} of {found[0]} and {found[1]}'
            )
        return snapshot

    def table(self, name: str) -> pd.DataFrame:
        """Return generations.csv or phases.csv, by its stem."""
        import pandas as pd  # here: a run is read without it

        return pd.DataFrame(self.columns(name))

    def columns(self, name: str) -> dict[str, np.ndarray]:
        """Return the columns of generations.csv or phases.csv, by its stem."""
        return read_columns(self.folder / f'{name}.csv', LOGS[name])


def read_run(folder: Path | str) -> Replication:
    """Open a run folder and check that no snapshot up to its last phase is missing or damaged.

    Parameters
    ----------
    folder : Path or str

    Raises
    ------
    AnalysisError, ReadingError
        It holds no run, or part of one is missing or damaged, in one sentence.

    Examples
    --------
    >>> import red_queen as rq
    >>> run = rq.read_run('runs/mine')
    >>> list(run.snapshots), run.configuration.population
    ([0, 10, 20], 8)
    """
    folder = Path(folder)
    configuration, named = read_record(folder / 'run.json')
    condition = assign({folder: configuration}, {folder: named})[folder]
    try:
        run = Replication(folder, configuration, named, condition, snapshots(folder))
    except ValueError as error:
        raise AnalysisError(str(error)) from None
    every = configuration.snapshot_generations
    ends = np.unique(np.append(0, run.columns('phases')['generation']))
    due = ends[np.append(True, ends[1:] // every > ends[:-1] // every)]
    missing = [int(g) for g in due if int(g) not in run.snapshots]
    if missing:
        raise AnalysisError(
            f'{folder}: the snapshot of generation {missing[0]} is missing '
            f'({len(missing)} of {len(due)} are)'
        )
    check_content(folder, configuration)
    return run


def read_runs(folders: Sequence[Path | str]) -> list[Replication]:
    """Open run folders and tell which are replications of one condition.

    Raises
    ------
    AnalysisError
        A folder is unusable or given twice, or replications of a condition share a seed.
    """
    runs = {Path(folder): read_run(folder) for folder in folders}
    places = [path.resolve() for path in runs]
    for path in runs:
        if places.count(path.resolve()) > 1 or [Path(f) for f in folders].count(path) > 1:
            raise AnalysisError(f'{path} is given twice')
    conditions = assign(
        {path: run.configuration for path, run in runs.items()},
        {path: run.named for path, run in runs.items()},
    )
    found = [replace(run, condition=conditions[path]) for path, run in runs.items()]
    for k, run in enumerate(found):
        for other in found[:k]:
            if (run.condition, run.seed) == (other.condition, other.seed):
                raise AnalysisError(
                    f'{other.folder} and {run.folder} are the same replication: seed {run.seed} '
                    'of one condition'
                )
    return sorted(found, key=lambda run: (*order(run.condition, run.configuration), run.seed))


def choose_generations(
    runs: Sequence[Replication], every: int | None = None, until: int | None = None
) -> list[int]:
    """Generations to look at: those of which every run has a snapshot, spaced by `every`.

    Parameters
    ----------
    every : int, optional
        Spacing; without it, 15 steps as in the paper, or all where fewer.
    until : int, optional
        The last generation; without it, the last that every run has reached.
    """
    common = sorted(set.intersection(*(set(run.snapshots) for run in runs)))
    last = common[-1] if common else 0
    if until is not None:
        if until not in common:
            raise AnalysisError(
                f'until is {until}, expected a generation of which every run has a snapshot'
                + (f', at most {last}' if common else '')
            )
        common = [g for g in common if g <= until]
    if len(common) < 2 or common[0] != 0:
        raise AnalysisError(
            'the runs have no two generations in common to compare, generation 0 and a later one'
        )
    if every is None:
        picks = np.linspace(0, len(common) - 1, min(len(common), POINTS + 1)).round().astype(int)
        chosen = [common[k] for k in picks]
    else:
        chosen = [g for g in common if g % every == 0]
        if len(chosen) < 2:
            raise AnalysisError(
                f'every is {every}, expected a spacing at which the runs have snapshots, '
                f'such as {common[1]}'
            )
    return chosen


def by_condition(runs: Sequence[Replication]) -> dict[Condition, list[Replication]]:
    """ConditionResults of each condition, in the order of `runs`."""
    groups: dict[Condition, list[Replication]] = {}
    for run in runs:
        groups.setdefault(run.condition, []).append(run)
    return groups

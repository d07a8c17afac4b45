"""Read run folders and group them: replications of conditions, conditions within environments."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from coevo_manager.analysis.logs import read_log
from coevo_manager.core.configuration import Configuration, differences
from coevo_manager.core.episodes import Environment
from coevo_manager.core.evolution import algorithms
from coevo_manager.core.evolution.checkpoint import check_content
from coevo_manager.core.evolution.run_folder import LOGS, read_configuration, read_run_json
from neuro_controller.core.snapshot import Snapshot, read_snapshot, snapshots

POINTS = 15  # as the paper: 150,000 generations looked at every 10,000


class AnalysisError(ValueError):
    """The runs cannot be analysed; one sentence that says why."""


@dataclass(frozen=True)
class Condition:
    """What replications share: all that is compared."""

    algorithm: str
    optimizer: str
    environment: str
    motor_map: str

    @property
    def slug(self) -> str:
        """Name for files."""
        return '-'.join((self.algorithm, self.optimizer, self.environment, self.motor_map))

    @property
    def name(self) -> str:
        """Name for people: the algorithm, and the optimizer where it is not the paper's."""
        algorithm = self.algorithm.replace('_', ' ').capitalize()
        if self.optimizer == 'one_plus_one':
            return algorithm
        return f'{algorithm}, {self.optimizer.replace("_", "-").upper()}'

    @property
    def arena(self) -> str:
        """The environment for people; runs are only ever mixed within one."""
        arena = 'open arena' if self.environment == 'open' else 'arena with obstacle'
        return arena if self.motor_map == 'printed' else f'{arena}, {self.motor_map} motor map'


@dataclass(frozen=True)
class Run:
    """A run folder: one replication."""

    folder: Path
    configuration: Configuration
    snapshots: dict[int, Path]

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.folder.resolve().name

    @property
    def seed(self) -> int:
        """Seed, which tells replications apart."""
        return self.configuration.seed

    @property
    def condition(self) -> Condition:
        """What it is a replication of."""
        return Condition(
            self.configuration.algorithm,
            self.configuration.optimizer,
            self.configuration.environment,
            self.configuration.motor_map,
        )

    @cached_property
    def environment(self) -> Environment:
        """Where the episodes of the analysis are played: each pair plays once."""
        return replace(self.configuration.make_environment(), repetitions=1)

    @cached_property
    def versions(self) -> str:
        """What it was evolved with, as its run.json tells."""
        versions = read_run_json(self.folder / 'run.json')['versions']
        return ', '.join(f'{name} {value}' for name, value in versions.items())

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
        if snapshot.generation != generation or found != (size, size):
            raise AnalysisError(
                f'{path} should hold generation {generation} of {size} predators and {size} prey, '
                f'but holds generation {snapshot.generation} of {found[0]} and {found[1]}'
            )
        return snapshot

    def table(self, name: str) -> pd.DataFrame:
        """generations.csv or phases.csv, by its stem."""
        return read_log(self.folder / f'{name}.csv', LOGS[name])


def read_run(folder: Path | str) -> Run:
    """Open a run folder and check that no snapshot up to its last phase is missing or damaged."""
    folder = Path(folder)
    configuration = read_configuration(folder)
    try:
        run = Run(folder, configuration, snapshots(folder))
    except ValueError as error:
        raise AnalysisError(str(error)) from None
    every = configuration.snapshot_generations
    ends = np.unique(np.append(0, run.table('phases')['generation'].to_numpy(int)))
    due = ends[np.append(True, ends[1:] // every > ends[:-1] // every)]
    missing = [int(g) for g in due if int(g) not in run.snapshots]
    if missing:
        raise AnalysisError(
            f'{folder}: the snapshot of generation {missing[0]} is missing '
            f'({len(missing)} of {len(due)} are)'
        )
    algorithm = algorithms.load(configuration.algorithm)(configuration)
    check_content(folder, configuration, algorithm)
    return run


def read_runs(folders: Sequence[Path | str]) -> list[Run]:
    """Open run folders and refuse what cannot be compared.

    Raises
    ------
    AnalysisError
        A folder is unusable or given twice; replications of a condition differ in more than their
        seed and budget, or share a seed; or runs said to be of one environment differ in it.
    """
    runs: list[Run] = []
    for folder in folders:
        run = read_run(folder)
        for other in runs:
            _check_pair(run, other)
        runs.append(run)
    return sorted(runs, key=lambda run: (*_order(run.condition), run.seed))


def _check_pair(run: Run, other: Run) -> None:
    both = f'{other.folder} and {run.folder}'
    if run.folder.resolve() == other.folder.resolve():
        raise AnalysisError(f'{run.folder} is given twice')
    if run.condition == other.condition:
        if run.seed == other.seed:
            raise AnalysisError(
                f'{both} are the same replication: seed {run.seed} of one condition'
            )
        same = {'seed': 0, 'phases': 1, 'episodes': None, 'ticks': None}
        different = differences(
            replace(other.configuration, **same), replace(run.configuration, **same)
        )
        if different:
            raise AnalysisError(
                f'{both} are no replications of each other, they differ in {different[0]}: '
                'analyse them apart'
            )
    elif run.condition.arena == other.condition.arena and run.environment != other.environment:
        one, two = asdict(other.environment), asdict(run.environment)
        field = next(name for name in one if one[name] != two[name])
        raise AnalysisError(
            f'{both} mix environments, {field} is {one[field]} and {two[field]}: analyse them '
            'apart'
        )


def _order(condition: Condition) -> tuple:
    paper = ('standard', 'simplified', 'vanilla')
    known = condition.algorithm in paper
    place = paper.index(condition.algorithm) if known else len(paper)
    arena = condition.motor_map, condition.environment != 'open'
    return *arena, place, condition.algorithm, condition.optimizer


def choose_generations(
    runs: Sequence[Run], every: int | None = None, until: int | None = None
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


def by_condition(runs: Sequence[Run]) -> dict[Condition, list[Run]]:
    """Replications of each condition, in the order of `runs`."""
    groups: dict[Condition, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.condition, []).append(run)
    return groups


def by_arena(conditions: Sequence[Condition]) -> dict[str, list[Condition]]:
    """Conditions of each environment: only these may be set against each other."""
    groups: dict[str, list[Condition]] = {}
    for condition in conditions:
        groups.setdefault(condition.arena, []).append(condition)
    return groups

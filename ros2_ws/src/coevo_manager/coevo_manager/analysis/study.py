"""Everything the figures, tables and the report need, measured from run folders."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from coevo_manager.analysis.conditions import Condition
from coevo_manager.analysis.measures import beyond
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.play import behaviours, probe
from coevo_manager.analysis.play.tournament import Block, Evaluations
from coevo_manager.analysis.runs import Replication, by_condition
from coevo_manager.core.behaviour import MEASURES
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.snapshot import Snapshot

Advance = Callable[[int], object]
Stage = Callable[[str, int], Advance]
"""Told of each stage of work, its title and size; returns what is told of each part done."""

Snapshots = Mapping[Path, Sequence[Snapshot]]
"""Those of each run, by its folder and in the order of the generations."""

FACED = ('contemporaries', 'fixed')
"""Whom the agents meet whose behaviour is measured: the best of their own generation, or those of
the last generation of their run."""


@dataclass
class ConditionResults:
    """What was measured of one condition; arrays have one row a run, in the order of `runs`.

    Attributes
    ----------
    condition : Condition
    runs : list of Replication, R of them
    snapshots : list of list of Snapshot, [run][generation]
    tournament : float64 (R, S, S)
        Predator fitness; row = predators' generation, column = prey's.
    complexity : dict of species to float64 (R, S)
        Population mean against the opponents of the same generation, rad/s per tick.
    profiles, paths : dict of species to float64 (R, S)
        Diversity of fitness profiles (0 to 1) and of paths (m).
    behaviour : dict of one of `FACED` to dict of species to dict of str to float64 (R, S)
        `behaviour.MEASURES` without sensor noise, over the `episodes` that no capture ended.
    held_out : dict of species to dict of Condition to float64 (R, S)
        Fitness of each generation against the last generation's best of *other* runs of a
        condition; a condition without other runs is left out.
    probes : dict of species to float32 (R, S, searches, candidates)
        Best fitness so far of fresh opponents of the champion of that species, see `probe`.
    reproduced : list of bool or None
        For each run: whether the kernel gives the fitness matrix that the run itself stored. None
        where each pair played several episodes: the analysis plays the first alone.
    """

    condition: Condition
    runs: list[Replication]
    snapshots: list[Sequence[Snapshot]]
    tournament: np.ndarray
    complexity: dict[str, np.ndarray]
    profiles: dict[str, np.ndarray]
    reproduced: list[bool | None]
    paths: dict[str, np.ndarray] = field(default_factory=dict)
    behaviour: dict[str, dict[str, dict[str, np.ndarray]]] = field(default_factory=dict)
    held_out: dict[str, dict[Condition, np.ndarray]] = field(default_factory=dict)
    probes: dict[str, np.ndarray] = field(default_factory=dict)

    def held_out_mean(self, species: str) -> np.ndarray | None:
        """Mean over the conditions that held-out opponents come from, (R, S); None without any."""
        tables = list(self.held_out[species].values())
        return np.mean(tables, axis=0) if tables else None


@dataclass
class Study:
    """All conditions at the same generations.

    Attributes
    ----------
    generations : int64 (S,)
    conditions : list of ConditionResults
    cross : dict of (Path, Path) to float
        Predator fitness of the first run's last predators against the second's last prey.
    budget : SearchBudget or None
    opponents : int
        Held-out opponents taken of each other run.
    evaluations : Evaluations
    played : int
        Episodes played for this study, stored results not counted.
    """

    generations: np.ndarray
    conditions: list[ConditionResults]
    budget: probe.SearchBudget | None
    opponents: int
    evaluations: Evaluations
    cross: dict[tuple[Path, Path], float] = field(default_factory=dict)
    played: int = 0

    def arenas(self) -> dict[str, list[ConditionResults]]:
        """Conditions of each arena: only these are set against each other."""
        groups: dict[str, list[ConditionResults]] = {}
        for each in self.conditions:
            groups.setdefault(each.condition.arena, []).append(each)
        return groups


def collect(
    runs: Sequence[Replication],
    generations: Sequence[int],
    evaluations: Evaluations,
    budget: probe.SearchBudget | None,
    opponents: int,
    stage: Stage,
) -> Study:
    """Measure everything."""
    snapshots = {run.folder: [run.snapshot(g) for g in generations] for run in runs}
    blocks = list(_all_blocks(runs, snapshots, opponents))
    played = evaluations.prepare(
        blocks, stage('Episodes between generations', sum(block.episodes for block in blocks))
    )
    conditions = [
        _measure(condition, members, snapshots, evaluations)
        for condition, members in by_condition(runs).items()
    ]
    study = Study(
        np.asarray(generations), conditions, budget, opponents, evaluations, played=played
    )
    _cross_and_held_out(study, snapshots)
    size = len(SPECIES) * len(runs) * len(generations)
    _sample(study, stage('Behaviour of individuals', (1 + len(FACED)) * size))
    if budget is not None:
        advance = stage('Search for best responses', size)
        for each in conditions:
            each.probes = {species: _probe(each, species, study, advance) for species in SPECIES}
    return study


def tournament_block(run: Replication, predators: Snapshot, prey: Snapshot) -> Block:
    """One cell of a run's tournament; on the diagonal complexity is measured too."""
    return Block(
        predators.predators, prey.prey, run.environment, predators.generation == prey.generation
    )


def _held_out_block(
    run: Replication, agents: Snapshot, other: Snapshot, species: str, count: int
) -> Block:
    elite = other.best(OTHER[species], count)
    own = agents.population(species)
    predators, prey = (own, elite) if species == 'predator' else (elite, own)
    return Block(predators, prey, run.environment)


def _all_blocks(
    runs: Sequence[Replication], snapshots: Snapshots, opponents: int
) -> Iterator[Block]:
    for run in runs:
        for predators in snapshots[run.folder]:
            for prey in snapshots[run.folder]:
                yield tournament_block(run, predators, prey)
    for run, other in _pairs(runs):
        yield _last_block(run, other, snapshots)
        for species in SPECIES:
            for agents in snapshots[run.folder]:
                yield _held_out_block(run, agents, snapshots[other.folder][-1], species, opponents)


def _last_block(run: Replication, other: Replication, snapshots: Snapshots) -> Block:
    predators, prey = snapshots[run.folder][-1].predators, snapshots[other.folder][-1].prey
    return Block(predators, prey, run.environment)


def _pairs(runs: Sequence[Replication]) -> Iterator[tuple[Replication, Replication]]:
    """Ordered pairs of different runs of one arena."""
    for run in runs:
        for other in runs:
            if run is not other and run.condition.arena == other.condition.arena:
                yield run, other


def _measure(
    condition: Condition,
    runs: list[Replication],
    snapshots: Snapshots,
    evaluations: Evaluations,
) -> ConditionResults:
    size = len(snapshots[runs[0].folder])
    tournament = np.empty((len(runs), size, size))
    complexity = {species: np.empty((len(runs), size)) for species in SPECIES}
    profiles = {species: np.empty((len(runs), size)) for species in SPECIES}
    reproduced: list[bool | None] = []
    for r, run in enumerate(runs):
        own = snapshots[run.folder]
        same = True
        for i, predators in enumerate(own):
            for j, prey in enumerate(own):
                result = evaluations[tournament_block(run, predators, prey)]
                tournament[r, i, j] = result.fitness.mean()
                if result.complexity is not None:
                    same &= bool(np.allclose(result.fitness, predators.fitness, atol=1e-6))
                    for robot, species in enumerate(SPECIES):
                        complexity[species][r, i] = result.complexity[..., robot].mean()
                        fitness = performance(result.fitness, species)
                        profiles[species][r, i] = beyond.profile_diversity(fitness)
        reproduced.append(same if run.configuration.episodes_per_opponent == 1 else None)
    return ConditionResults(
        condition,
        runs,
        [snapshots[run.folder] for run in runs],
        tournament,
        complexity,
        profiles,
        reproduced,
    )


def _cross_and_held_out(study: Study, snapshots: Snapshots) -> None:
    runs = [run for each in study.conditions for run in each.runs]
    for each in study.conditions:
        for r, run in enumerate(each.runs):
            study.cross[run.folder, run.folder] = float(each.tournament[r, -1, -1])
    for run, other in _pairs(runs):
        result = study.evaluations[_last_block(run, other, snapshots)]
        study.cross[run.folder, other.folder] = float(result.fitness.mean())
    for members in study.arenas().values():
        for each in members:
            each.held_out = {
                species: {
                    source.condition: np.array(
                        [
                            _held_out(run, source.runs, species, study, snapshots)
                            for run in each.runs
                        ]
                    )
                    for source in members
                    if source is not each or len(each.runs) > 1
                }
                for species in SPECIES
            }


def _held_out(
    run: Replication,
    sources: Sequence[Replication],
    species: str,
    study: Study,
    snapshots: Snapshots,
) -> np.ndarray:
    """Fitness (S,) of a run's generations against the last elites of other runs."""
    curves = []
    for other in sources:
        if other is run:
            continue
        last = snapshots[other.folder][-1]
        curve = []
        for agents in snapshots[run.folder]:
            fitness = study.evaluations[
                _held_out_block(run, agents, last, species, study.opponents)
            ].fitness.mean()
            curve.append(fitness if species == 'predator' else 1.0 - fitness)
        curves.append(curve)
    return np.mean(curves, axis=0)


def _sample(study: Study, advance: Advance) -> None:
    """Fill in the paths and the behaviour of all conditions, in one go of the worker processes."""
    places, jobs = [], []
    for each in study.conditions:
        for species in SPECIES:
            for faced in ('', *FACED):
                places.append((each, species, faced))
                for run, own in zip(each.runs, each.snapshots, strict=True):
                    jobs += _sample_jobs(run, own, species, faced)
    found = iter(
        study.evaluations.compute(behaviours.sample, jobs, processes=True, advance=advance)
    )
    for each, species, faced in places:
        shape = len(each.runs), len(study.generations)
        values = [next(found) for _ in range(shape[0] * shape[1])]
        if not faced:
            each.paths[species] = np.reshape([beyond.path_diversity(p) for p in values], shape)
            continue
        columns = np.array(values).reshape(*shape, 1 + len(MEASURES))
        each.behaviour.setdefault(faced, {})[species] = dict(
            zip(('episodes', *MEASURES), np.moveaxis(columns, -1, 0), strict=True)
        )


def _sample_jobs(
    run: Replication, own: Sequence[Snapshot], species: str, faced: str
) -> list[behaviours.Job]:
    """Jobs of each generation of a run: its paths, or its behaviour against those it faces."""
    if not faced:
        return [behaviours.paths_job(snapshot, species, run.environment) for snapshot in own]
    return [
        behaviours.behaviour_job(
            snapshot, snapshot if faced == 'contemporaries' else own[-1], species, run.environment
        )
        for snapshot in own
    ]


def _probe(each: ConditionResults, species: str, study: Study, advance: Advance) -> np.ndarray:
    assert study.budget is not None
    champions = [s.best(species, 1)[0] for own in each.snapshots for s in own]
    environment = each.runs[0].environment
    history = probe.probe(
        study.evaluations, champions, species, environment, study.budget, advance
    )
    return history.reshape(len(each.runs), -1, *history.shape[1:])

"""Everything the figures, tables and the report need, measured from run folders."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np

from coevo_manager.analysis.measures import beyond
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.play import exploit
from coevo_manager.analysis.play.tournament import Block, Evaluations, content_hash
from coevo_manager.analysis.runs import Condition, Run, by_arena, by_condition
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.snapshot import Snapshot

PATH_MOMENTS = 21
PATH_INDIVIDUALS = 10


@dataclass
class Replications:
    """What was measured of one condition; arrays have one row a run, in the order of `runs`.

    Attributes
    ----------
    condition : Condition
    runs : list of Run, R of them
    snapshots : list of list of Snapshot, [run][generation]
    tournament : float64 (R, S, S)
        Predator fitness; row = predators' generation, column = prey's.
    complexity : dict of species to float64 (R, S)
        Population mean against the opponents of the same generation, rad/s per tick.
    profiles, paths : dict of species to float64 (R, S)
        Diversity of fitness profiles (0 to 1) and of paths (m).
    held_out : dict of species to dict of Condition to float64 (R, S)
        Fitness of each generation against the last generation's best of *other* runs of a
        condition; a condition without other runs is left out.
    probes : dict of species to float32 (R, S, searches, candidates)
        Best fitness so far of fresh opponents of the champion of that species, see `exploit`.
    reproduced : list of bool
        For each run: whether the kernel gives the fitness matrix that the run itself stored.
    """

    condition: Condition
    runs: list[Run]
    snapshots: list[list[Snapshot]]
    tournament: np.ndarray
    complexity: dict[str, np.ndarray]
    profiles: dict[str, np.ndarray]
    reproduced: list[bool]
    paths: dict[str, np.ndarray] = field(default_factory=dict)
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
    conditions : list of Replications
    cross : dict of (Run.folder, Run.folder) to float
        Predator fitness of the first run's last predators against the second's last prey.
    budget : Budget or None
    opponents : int
        Held-out opponents taken of each other run.
    evaluations : Evaluations
    played : int
        Episodes played for this study, stored results not counted.
    """

    generations: np.ndarray
    conditions: list[Replications]
    budget: exploit.Budget | None
    opponents: int
    evaluations: Evaluations
    cross: dict = field(default_factory=dict)
    played: int = 0

    def arenas(self) -> dict[str, list[Replications]]:
        """Conditions of each environment."""
        groups = by_arena([each.condition for each in self.conditions])
        found = {each.condition: each for each in self.conditions}
        return {arena: [found[c] for c in members] for arena, members in groups.items()}


def collect(
    runs: Sequence[Run],
    generations: Sequence[int],
    evaluations: Evaluations,
    budget: exploit.Budget | None,
    opponents: int,
    stage,
) -> Study:
    """Measure everything.

    Parameters
    ----------
    stage : callable (title, total) -> advance(amount)
        Progress: called once for each stage of the work.
    """
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
    advance = stage('Paths of individuals', 2 * len(runs) * len(generations))
    for each in conditions:
        each.paths = {species: _paths(each, species, evaluations, advance) for species in SPECIES}
    if budget is not None:
        advance = stage('Search for best responses', 2 * len(runs) * len(generations))
        for each in conditions:
            each.probes = {species: _probe(each, species, study, advance) for species in SPECIES}
    return study


def tournament_block(run: Run, predators: Snapshot, prey: Snapshot) -> Block:
    """One cell of a run's tournament; on the diagonal complexity is measured too."""
    return Block(
        predators.predators, prey.prey, run.environment, predators.generation == prey.generation
    )


def _held_out_block(
    run: Run, agents: Snapshot, other: Snapshot, species: str, count: int
) -> Block:
    elite = other.best(OTHER[species], count)
    own = agents.population(species)
    pair = (own, elite) if species == 'predator' else (elite, own)
    return Block(*pair, run.environment)


def _all_blocks(runs, snapshots, opponents) -> Iterator[Block]:
    for run in runs:
        for predators in snapshots[run.folder]:
            for prey in snapshots[run.folder]:
                yield tournament_block(run, predators, prey)
    for run, other in _pairs(runs):
        yield Block(
            snapshots[run.folder][-1].predators, snapshots[other.folder][-1].prey, run.environment
        )
        for species in SPECIES:
            for agents in snapshots[run.folder]:
                yield _held_out_block(run, agents, snapshots[other.folder][-1], species, opponents)


def _pairs(runs) -> Iterator[tuple[Run, Run]]:
    """Ordered pairs of different runs of one environment."""
    for run in runs:
        for other in runs:
            if run is not other and run.condition.arena == other.condition.arena:
                yield run, other


def _measure(condition, runs, snapshots, evaluations) -> Replications:
    size = len(snapshots[runs[0].folder])
    tournament = np.empty((len(runs), size, size))
    complexity = {species: np.empty((len(runs), size)) for species in SPECIES}
    profiles = {species: np.empty((len(runs), size)) for species in SPECIES}
    reproduced = []
    for r, run in enumerate(runs):
        own = snapshots[run.folder]
        same = True
        for i, predators in enumerate(own):
            for j, prey in enumerate(own):
                result = evaluations[tournament_block(run, predators, prey)]
                tournament[r, i, j] = result.fitness.mean()
                if i == j:
                    same &= bool(np.allclose(result.fitness, predators.fitness, atol=1e-6))
                    complexity['predator'][r, i] = result.complexity[..., 0].mean()
                    complexity['prey'][r, i] = result.complexity[..., 1].mean()
                    for species in SPECIES:
                        fitness = performance(result.fitness, species)
                        profiles[species][r, i] = beyond.profile_diversity(fitness)
        reproduced.append(same)
    return Replications(
        condition,
        runs,
        [snapshots[run.folder] for run in runs],
        tournament,
        complexity,
        profiles,
        reproduced,
    )


def _cross_and_held_out(study: Study, snapshots) -> None:
    runs = [run for each in study.conditions for run in each.runs]
    for each in study.conditions:
        for r, run in enumerate(each.runs):
            study.cross[run.folder, run.folder] = float(each.tournament[r, -1, -1])
    for run, other in _pairs(runs):
        block = Block(
            snapshots[run.folder][-1].predators, snapshots[other.folder][-1].prey, run.environment
        )
        study.cross[run.folder, other.folder] = float(study.evaluations[block].fitness.mean())
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
    run: Run, sources: Sequence[Run], species: str, study: Study, snapshots
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


def _paths(each: Replications, species: str, evaluations: Evaluations, advance) -> np.ndarray:
    """Diversity of paths (R, S): individuals of every rank against the generation's champion."""
    jobs = []
    for run, own in zip(each.runs, each.snapshots, strict=True):
        for snapshot in own:
            champion = snapshot.best(OTHER[species], 1)[0]
            ranking = snapshot.ranking(species)
            count = min(PATH_INDIVIDUALS, len(ranking))
            chosen = ranking[np.linspace(0, len(ranking) - 1, count).round().astype(int)]
            genomes = snapshot.population(species)[chosen]
            digest = content_hash('paths', species, asdict(run.environment), genomes, champion)
            jobs.append((digest, (genomes, champion, species, run.environment)))
    paths = evaluations.compute(sample_paths, jobs, processes=True, advance=advance)
    return np.reshape([beyond.path_diversity(p) for p in paths], (len(each.runs), -1))


def sample_paths(kernel, genomes, champion, species: str, environment) -> np.ndarray:
    """Positions (n, 21, 2) of n individuals at equal times over the longest episode, m.

    After a capture the position stays what it was.
    """
    moments = np.linspace(0, environment.episode_ticks, PATH_MOMENTS).round().astype(int)
    paths = []
    for genome in genomes:
        pair = (genome, champion) if species == 'predator' else (champion, genome)
        poses = np.asarray(kernel.trace(*pair, environment).poses)
        paths.append(poses[np.minimum(moments, len(poses) - 1), SPECIES.index(species), :2])
    return np.array(paths)


def _probe(each: Replications, species: str, study: Study, advance) -> np.ndarray:
    champions = [s.best(species, 1)[0] for own in each.snapshots for s in own]
    environment = each.runs[0].environment
    history = exploit.probe(
        study.evaluations, champions, species, environment, study.budget, advance
    )
    return history.reshape(len(each.runs), -1, *history.shape[1:])

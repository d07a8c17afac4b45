"""A whole run: phases of evolution, kept in a run folder."""

from __future__ import annotations

import dataclasses
import threading
from pathlib import Path

import numpy as np

from coevo_manager.core.configuration import Configuration, differences
from coevo_manager.core.evaluation import Evaluator, StoppedError, evaluate_all
from coevo_manager.core.evolution import algorithms
from coevo_manager.core.evolution.budget import RunBudget
from coevo_manager.core.evolution.loading import complete, memory_size, remarks
from coevo_manager.core.evolution.matchup import Opponents
from coevo_manager.core.evolution.observation import (
    GenerationStats,
    Observer,
    Outcome,
    PhaseStats,
)
from coevo_manager.core.evolution.phase import Generation, Phase, evolve
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.report import write_report
from coevo_manager.core.evolution.run_folder import (
    RunFolder,
    RunFolderError,
    read_configuration,
)
from coevo_manager.core.evolution.sessions import Session, remark_on_program
from coevo_manager.core.evolution.state import State, fitness_of
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.genome import random_genomes


class Evolution:
    """One run of co-evolution, repeatable and durable.

    Parameters
    ----------
    configuration : Configuration
        Everything that decides the results; the files of two runs of it are equal byte for byte
        (but run.log and sessions.json), whatever the evaluator's speed, number of slots and order
        of answers.
    evaluator : Evaluator
        Plays the episodes; it stays the caller's to close.
    run_folder : Path or str
        Folder to create; an existing one must be empty.
    observer : Observer, optional
        Called with `GenerationStats` after each generation, and with `PhaseStats` after each
        phase, while its checkpoint is being written.
    condition : str
        What the user calls this configuration, to be kept in run.json; '' without a name.

    Raises
    ------
    RunFolderError
        The folder holds something already, or cannot be written.
    ValueError
        The evaluator's environment is not the configuration's, or the configuration's fields do
        not go together.
    """

    def __init__(
        self,
        configuration: Configuration,
        evaluator: Evaluator,
        run_folder: Path | str,
        observer: Observer | None = None,
        condition: str = '',
    ) -> None:
        configuration = complete(configuration)
        _check_environment(configuration, evaluator)
        folder = RunFolder.create(Path(run_folder), configuration, condition)
        self._prepare(configuration, evaluator, folder, observer)

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
        held = read_configuration(run_folder)
        if configuration is not None and configuration != held:
            raise RunFolderError(
                f'{run_folder} holds a run of another configuration '
                f'(there, here): {"; ".join(differences(held, configuration))}'
            )
        _check_environment(held, evaluator)
        evolution = cls.__new__(cls)
        evolution._prepare(held, evaluator, RunFolder(Path(run_folder)), observer)
        return evolution

    def _prepare(
        self,
        configuration: Configuration,
        evaluator: Evaluator,
        folder: RunFolder,
        observer: Observer | None,
    ) -> None:
        self.configuration = configuration
        self._evaluator = evaluator
        self._folder = folder
        self._observer = observer
        self._stop = threading.Event()
        self._budget = RunBudget(configuration)
        self._algorithm = algorithms.load(configuration.algorithm)(configuration)
        try:
            self._state = folder.restore(configuration, self._algorithm)
        except RunFolderError:
            folder.close()
            raise
        if remark := remark_on_program(folder.path):
            self.log(remark)
        self._session = Session(folder.path, self._state.phase if self._state else 0)
        for remark in remarks(configuration, configuration.phases):
            self.log(remark)

    def run(self) -> Outcome:
        """Evolve till the budget is spent or `stop` is called, and write the report; once.

        Raises
        ------
        RunFolderError
            The folder cannot be written (a full disk). What it holds stays valid: resume it.
        """
        report, ended = '', 'failed'
        try:
            if self._state is None:
                self.log('started')
                self._state = self._first_state()
            while generations := self._generations_left(self._state):
                self._run_phase(self._state, generations)
            self._folder.finish_saving()
            report = self._report(self._state)
            self.log('finished')
            ended = 'finished'
        except StoppedError:
            self.log('stopped on request')
            self._folder.finish_saving()
            ended = 'stopped'
        except BaseException as error:
            self.log(f'ended by {type(error).__name__}: {error}')
            raise
        finally:
            self._evaluator.cancel()
            self._session.end(self._state.phase if self._state else 0, ended)
            self._folder.close()
        return Outcome(finished=bool(report), folder=self._folder.path, report=report)

    def stop(self) -> None:
        """Ask the run to end within a generation; from any thread or a signal handler.

        The folder stays valid and `resume` continues it as if it had never stopped.
        """
        self._stop.set()

    def log(self, message: str) -> None:
        """Add a line with the wall-clock time to run.log; from any thread."""
        self._folder.log(message)

    def _first_state(self) -> State:
        """Draw both populations, evaluate everyone against everyone, and save."""
        predators, prey = self._first_populations()
        ticks = evaluate_all(self._evaluator, predators, prey, self._stop)
        size = memory_size(self.configuration)
        memory = {species: np.zeros((len(prey), size)) for species in SPECIES}
        state = State(predators, prey, ticks, self.configuration.pair_ticks, memory=memory)
        self._add_cost(state, ticks)
        for species in SPECIES:
            self._algorithm.remember(state, species)
        self._save(state, [], evolving='', retained=0, snapshot=True)
        return state

    def _first_populations(self) -> tuple[np.ndarray, np.ndarray]:
        size, seed = self.configuration.population, self.configuration.seed
        layout = self.configuration.layout
        return (
            random_genomes(size, generator(seed, 'first predators'), layout),
            random_genomes(size, generator(seed, 'first prey'), layout),
        )

    def _run_phase(self, state: State, generations: int) -> None:
        """Evolve one species for one phase, choose who stays, swap where due, and save."""
        configuration, species = self.configuration, state.evolving
        rng = generator(configuration.seed, 'opponents', state.phase + 1)
        opponents = self._algorithm.opponents(state, rng)
        fitness = self._fitness_against(state, opponents)
        noises = self._noises(state, generations)
        agents = self._algorithm.start(state, fitness, rng)
        if self._budget.measures_agents:
            training = self._training(state, agents.genomes, opponents, noises[0])
            agents = dataclasses.replace(agents, training=training)
        rivals = self._algorithm.rivals(state)
        phase = Phase(state.phase + 1, species, generations, agents, opponents, rivals, noises)
        before = state.generation
        log: list[GenerationStats] = []
        means = tuple(state.mean_fitness(species) for species in SPECIES)
        evolved = evolve(
            phase,
            configuration,
            self._evaluator,
            self._stop,
            lambda generation: log.append(self._count(state, phase, generation, means)),
        )
        self._add_cost(state, evolved.capture_ticks)
        if self._budget.measures_evolved:
            training = self._training(state, evolved.genomes, opponents)
            evolved = dataclasses.replace(evolved, training=training)
        retained = self._algorithm.settle(state, agents, fitness, evolved)
        state.phase = phase.number
        self._algorithm.remember(state, species)
        if _crossed(before, state.generation, configuration.swap_generations):
            state.evolving = OTHER[species]
        last = not self._generations_left(state)
        due = _crossed(before, state.generation, configuration.snapshot_generations)
        self._save(state, log, species, retained, snapshot=due or last)

    def _count(
        self, state: State, phase: Phase, generation: Generation, means: tuple[float, ...]
    ) -> GenerationStats:
        """Add a completed generation to the run's cost and tell the observer."""
        state.generation += 1
        state.episodes += self._budget.generation
        state.ticks += generation.ticks
        stats = GenerationStats(
            state.generation,
            phase.number,
            phase.species,
            generation.fitness_mean,
            generation.fitness_min,
            generation.fitness_max,
            generation.accepted,
            state.episodes,
            state.ticks,
            means[0],
            means[1],
            self._progress(state),
        )
        self._observe(stats)
        return stats

    def _fitness_against(self, state: State, opponents: Opponents) -> np.ndarray | None:
        """Return the incumbents' fitness against the opponents, (N, m), in ticks, if wanted."""
        species = state.evolving
        if opponents.index is not None:
            return state.fitness(species)[:, opponents.index]
        if not self._algorithm.external_opponents:
            return None
        return self._measure(state, state.genomes(species), opponents)

    def _training(
        self, state: State, genomes: np.ndarray, opponents: Opponents, noise: int = 0
    ) -> np.ndarray:
        """Return fitness summed over the opponents, int64 (n,), in ticks."""
        return self._measure(state, genomes, opponents, noise).sum(axis=1, dtype=np.int64)

    def _measure(
        self, state: State, genomes: np.ndarray, opponents: Opponents, noise: int = 0
    ) -> np.ndarray:
        """Return fitness against each opponent, (n, m), in ticks; the episodes are counted."""
        species, stop = state.evolving, self._stop
        if species == 'predator':
            ticks = evaluate_all(self._evaluator, genomes, opponents.genomes, stop, noise)
        else:
            ticks = evaluate_all(self._evaluator, opponents.genomes, genomes, stop, noise).T
        self._add_cost(state, ticks)
        return fitness_of(species, ticks, state.pair_ticks)

    def _noises(self, state: State, generations: int) -> list[int]:
        """Return the starts and noise of each generation of the next phase, see `Batch`."""
        fresh = self.configuration.fresh_noise
        if fresh == 'generation':
            return [state.generation + 1 + k for k in range(generations)]
        return [state.phase + 1 if fresh == 'phase' else 0] * generations

    def _add_cost(self, state: State, capture_ticks: np.ndarray) -> None:
        state.episodes += capture_ticks.size * self.configuration.episodes_per_opponent
        state.ticks += int(capture_ticks.sum(dtype=np.int64))

    def _save(
        self,
        state: State,
        generations: list[GenerationStats],
        evolving: str,
        retained: int,
        snapshot: bool,
    ) -> None:
        stats = PhaseStats(
            state.phase,
            state.generation,
            evolving,
            state.mean_fitness('predator'),
            state.mean_fitness('prey'),
            retained,
            state.episodes,
            state.ticks,
            self._progress(state) if self._generations_left(state) else 1.0,
        )
        self._folder.save(self.configuration, state, self._algorithm, generations, stats, snapshot)
        self.log(f'completed phase {state.phase}, generation {state.generation}')
        self._observe(stats)

    def _report(self, state: State) -> str:
        predators, prey = self._first_populations()
        ticks = [
            evaluate_all(self._evaluator, ours, theirs, self._stop)
            for ours, theirs in (
                (predators, prey),
                (state.predators, prey),
                (predators, state.prey),
            )
        ]
        report = write_report(self.configuration, state, *ticks)
        self._folder.save_report(report)
        return report

    def _generations_left(self, state: State) -> int:
        return self._budget.generations_left(state, len(self._algorithm.rivals(state)))

    def _progress(self, state: State) -> float:
        return self._budget.progress(state.generation, state.episodes, state.ticks)

    def _observe(self, stats: GenerationStats | PhaseStats) -> None:
        if self._observer is not None:
            self._observer(stats)


def _crossed(before: int, after: int, interval: int) -> bool:
    """Whether a multiple of the interval lies in (before, after]."""
    return after // interval > before // interval


def _check_environment(configuration: Configuration, evaluator: Evaluator) -> None:
    wanted = configuration.make_environment()
    if evaluator.environment != wanted:
        raise ValueError(
            f"the evaluator's environment is {evaluator.environment}, expected that of the run, "
            f'{wanted}'
        )

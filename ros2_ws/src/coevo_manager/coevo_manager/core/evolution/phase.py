"""One phase: agents evolve against fixed opponents, each lineage on its own.

Agents of a phase do not interact, so they go in groups, and each group asks, submits and tells
without waiting for the others: no evaluator idles at the end of a generation. Each agent draws
from its own generator, so that the grouping and the order of answers change no result.
"""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evaluation import Batch, Evaluator, next_answer
from coevo_manager.core.evolution import optimizers
from coevo_manager.core.evolution.optimizer import Optimizer
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.state import fitness_of


@dataclasses.dataclass(frozen=True)
class Phase:
    """What is fixed during a phase.

    Attributes
    ----------
    number : int
        From 1.
    species : str
        The evolving one.
    generations : int
        Length of the phase.
    agents : float32 (n, 442)
    training : int64 (n,)
        The agents' fitness summed over the opponents, in ticks.
    opponents : float32 (m, 442)
    """

    number: int
    species: str
    generations: int
    agents: np.ndarray
    training: np.ndarray
    opponents: np.ndarray


@dataclasses.dataclass(slots=True)
class Generation:
    """What happened in one generation of a phase, over all agents.

    Attributes
    ----------
    fitness : float64 (n,)
        Agents' mean fitness over the opponents, after replacement.
    accepted : int
        Agents that were replaced.
    ticks : int
        Ticks simulated.
    groups : int
        Groups of agents that have completed it.
    """

    fitness: np.ndarray
    accepted: int = 0
    ticks: int = 0
    groups: int = 0


class _Group:
    """Some agents of a phase, whose candidates are evaluated in one batch."""

    def __init__(
        self, phase: Phase, members: np.ndarray, optimizers: list[Optimizer], episode_ticks: int
    ) -> None:
        self.members = members
        self.generation = 0
        self._optimizers = optimizers
        self._species = phase.species
        self._episode_ticks = episode_ticks
        first = [optimizer.ask() for optimizer in optimizers]
        self._candidates = len(first[0])
        self._genomes = np.concatenate(first)
        index = np.indices((len(self._genomes), len(phase.opponents)), np.uint32).reshape(2, -1)
        ours = (self._genomes, index[0])
        theirs = (phase.opponents, index[1])
        predator, prey = (ours, theirs) if phase.species == 'predator' else (theirs, ours)
        self.batch = Batch(predator[0], prey[0], predator[1], prey[1])

    def tell(self, capture_ticks: np.ndarray, generation: Generation) -> None:
        """Give each optimizer its candidates' fitness and record the outcome."""
        ticks = capture_ticks.reshape(len(self._genomes), -1)
        most = ticks.shape[1] * self._episode_ticks
        totals = ticks.sum(axis=1, dtype=np.int64)
        fitness = (fitness_of(self._species, totals, most) / most).reshape(-1, self._candidates)
        for member, optimizer, results in zip(
            self.members, self._optimizers, fitness, strict=True
        ):
            generation.accepted += optimizer.tell(results)
            generation.fitness[member] = optimizer.best_fitness
        generation.ticks += int(totals.sum())
        generation.groups += 1
        self.generation += 1

    def ask(self) -> None:
        """Refill the batch with each optimizer's new candidates."""
        k = self._candidates
        for row, optimizer in enumerate(self._optimizers):
            self._genomes[row * k : (row + 1) * k] = optimizer.ask()


def evolve(
    phase: Phase,
    configuration: Configuration,
    evaluator: Evaluator,
    stop: threading.Event,
    on_generation: Callable[[Generation], None],
) -> tuple[np.ndarray, np.ndarray]:
    """Run a phase.

    Parameters
    ----------
    phase : Phase
    configuration : Configuration
    evaluator : Evaluator
    stop : Event
        Set to end the phase at once.
    on_generation : callable
        Called with each completed generation, in order.

    Returns
    -------
    genomes : float32 (n, 442)
        The evolved agents.
    training : int64 (n,)
        Their fitness summed over the opponents, in ticks.

    Raises
    ------
    StoppedError
    """
    most = len(phase.opponents) * configuration.episode_ticks
    kind = optimizers.load(configuration.optimizer)
    agents = [
        kind(
            genome,
            fitness / most,
            configuration,
            generator(configuration.seed, 'agent', phase.number, agent),
        )
        for agent, (genome, fitness) in enumerate(zip(phase.agents, phase.training, strict=True))
    ]
    groups = [
        _Group(phase, members, [agents[i] for i in members], configuration.episode_ticks)
        for members in np.array_split(np.arange(len(agents)), min(evaluator.slots, len(agents)))
    ]
    records: list[Generation] = []
    reported = 0
    running = {evaluator.submit(group.batch): group for group in groups}
    while running:
        ticket, ticks = next_answer(evaluator, stop)
        group = running.pop(ticket)
        if group.generation == len(records):
            records.append(Generation(np.empty(len(agents))))
        group.tell(ticks, records[group.generation])
        if group.generation < phase.generations:
            group.ask()
            running[evaluator.submit(group.batch)] = group
        while reported < len(records) and records[reported].groups == len(groups):
            on_generation(records[reported])
            reported += 1
    genomes = np.array([agent.best for agent in agents])
    training = np.array([round(agent.best_fitness * most) for agent in agents])
    return genomes, training

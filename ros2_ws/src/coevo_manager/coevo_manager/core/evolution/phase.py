"""One phase: agents evolve against fixed opponents, each lineage on its own.

Agents of a phase do not interact. Each asks for work as soon as its last was done, without waiting
for the others, and draws from its own generator, so that the order of answers changes no result.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from collections.abc import Callable

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evaluation import Batch, Evaluator, Lineage, all_pairs, next_answer
from coevo_manager.core.evolution import optimizers
from coevo_manager.core.evolution.optimizer import Optimizer
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.state import fitness_of

SHARE = 0.6
"""Share of its generations left that a lineage is asked for at once, ..."""

SHORTEST_SHARE = 16
"""... but at least so many: requests are few, and all evaluators end a phase together."""


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
    rivals : float32 (N, 442)
        The opposing population, which every agent meets when it has evolved.
    """

    number: int
    species: str
    generations: int
    agents: np.ndarray
    training: np.ndarray
    opponents: np.ndarray
    rivals: np.ndarray


@dataclasses.dataclass(frozen=True, slots=True)
class Generation:
    """What happened in one generation of a phase, over all agents.

    Attributes
    ----------
    fitness_mean, fitness_min, fitness_max : float
        Of the agents' mean fitness over the opponents, after replacement.
    accepted : int
        Agents that were replaced.
    ticks : int
        Ticks simulated.
    """

    fitness_mean: float
    fitness_min: float
    fitness_max: float
    accepted: int
    ticks: int


@dataclasses.dataclass(frozen=True)
class Evolved:
    """What a phase has made of its agents.

    Attributes
    ----------
    genomes : float32 (n, 442)
    training : int64 (n,)
        Their fitness summed over the opponents, in ticks.
    capture_ticks : int32 (n, N)
        Of their episodes against the rivals.
    """

    genomes: np.ndarray
    training: np.ndarray
    capture_ticks: np.ndarray


class _Agent:
    """One agent: what it wants to have played next, and how far it has come."""

    def __init__(
        self, phase: Phase, index: int, optimizer: Optimizer, configuration: Configuration
    ) -> None:
        self.index = index
        self.completed = 0
        self.training = int(phase.training[index])
        self._phase = phase
        self._optimizer = optimizer
        self._candidates = optimizer.candidates(configuration)
        self._most = len(phase.opponents) * configuration.pair_ticks

    @property
    def genome(self) -> np.ndarray:
        """The agent as it is now, float32 (442,)."""
        return self._optimizer.best

    def next_work(self, longest_lineage: int) -> Batch | Lineage:
        """Return the next generations of its lineage, or the candidates of one generation."""
        species, opponents = self._phase.species, self._phase.opponents
        left = self._phase.generations - self.completed
        share = max(math.ceil(left * SHARE), min(SHORTEST_SHARE, left))
        mutations = self._optimizer.mutations(min(share, longest_lineage))
        if mutations is None:
            return all_pairs(species, self._optimizer.ask(), opponents)
        genes, values = zip(*mutations, strict=True)
        return Lineage(
            species,
            self.genome.copy(),
            fitness_of(species, self.training, self._most),
            opponents,
            np.array([len(redrawn) for redrawn in genes], np.uint32),
            np.concatenate(genes).astype(np.uint32),
            np.concatenate(values),
        )

    def take(self, capture_ticks: np.ndarray, journal: _Journal) -> None:
        """Go on by the generations whose episodes were played."""
        opponents = len(self._phase.opponents)
        episodes = capture_ticks.reshape(-1, self._candidates, opponents)
        totals = episodes.sum(axis=2, dtype=np.int64)
        accepted, best = [], []
        for fitness in fitness_of(self._phase.species, totals, self._most) / self._most:
            accepted.append(self._optimizer.tell(fitness))
            best.append(self._optimizer.best_fitness)
        self.training = round(self._optimizer.best_fitness * self._most)
        first, self.completed = self.completed, self.completed + len(totals)
        done = slice(first, self.completed)
        journal.fitness[done, self.index] = best
        journal.accepted[done, self.index] = accepted
        journal.ticks[done, self.index] = totals.sum(axis=1)


class _Journal:
    """What is known of each generation and agent, and what was told of it."""

    def __init__(self, generations: int, agents: int) -> None:
        self.fitness = np.empty((generations, agents))
        self.accepted = np.empty((generations, agents), bool)
        self.ticks = np.empty((generations, agents), np.int64)
        self._told = 0

    def tell(self, completed: int, on_generation: Callable[[Generation], None]) -> None:
        """Tell of the generations up to `completed` that were not told before."""
        new = slice(self._told, completed)
        self._told = completed
        fitness = self.fitness[new]
        for values in zip(
            fitness.mean(axis=1).tolist(),
            fitness.min(axis=1).tolist(),
            fitness.max(axis=1).tolist(),
            self.accepted[new].sum(axis=1).tolist(),
            self.ticks[new].sum(axis=1).tolist(),
            strict=True,
        ):
            on_generation(Generation(*values))


def evolve(
    phase: Phase,
    configuration: Configuration,
    evaluator: Evaluator,
    stop: threading.Event,
    on_generation: Callable[[Generation], None],
) -> Evolved:
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

    Raises
    ------
    StoppedError
    """
    agents = _make_agents(phase, configuration)
    journal = _Journal(phase.generations, len(agents))
    capture_ticks = np.empty((len(agents), len(phase.rivals)), np.int32)
    idle = agents.copy()
    running: dict[int, _Agent] = {}
    while idle or running:
        while idle and len(running) < evaluator.slots:
            agent = min(idle, key=lambda agent: agent.completed)
            idle.remove(agent)
            if agent.completed < phase.generations:
                work = agent.next_work(evaluator.longest_lineage)
            else:
                work = all_pairs(phase.species, agent.genome[np.newaxis], phase.rivals)
            running[evaluator.submit(work)] = agent
        ticket, ticks = next_answer(evaluator, stop)
        agent = running.pop(ticket)
        if agent.completed < phase.generations:
            agent.take(ticks, journal)
            idle.append(agent)
            journal.tell(min(agent.completed for agent in agents), on_generation)
        else:
            capture_ticks[agent.index] = ticks
    return Evolved(
        np.array([agent.genome for agent in agents]),
        np.array([agent.training for agent in agents]),
        capture_ticks,
    )


def _make_agents(phase: Phase, configuration: Configuration) -> list[_Agent]:
    most = len(phase.opponents) * configuration.pair_ticks
    kind = optimizers.load(configuration.optimizer)
    agents = []
    for index, (genome, training) in enumerate(zip(phase.agents, phase.training, strict=True)):
        rng = generator(configuration.seed, 'agent', phase.number, index)
        optimizer = kind(genome, training / most, configuration, rng)
        agents.append(_Agent(phase, index, optimizer, configuration))
    return agents

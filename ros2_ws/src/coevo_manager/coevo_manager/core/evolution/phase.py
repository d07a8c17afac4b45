"""One phase: agents evolve against fixed opponents, each lineage on its own.

Agents of a phase do not interact. Each asks for work as soon as its last was done, without waiting
for the others, and draws from its own generator, so that neither the order of answers nor who asks
together with whom changes a result.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import threading
from collections.abc import Callable, Sequence

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evaluation import (
    LONGEST_BATCH,
    Batch,
    Evaluator,
    Lineages,
    all_pairs,
    joined,
    next_answer,
    some_pairs,
)
from coevo_manager.core.evolution import optimizers
from coevo_manager.core.evolution.matchup import Agents, Draw, Evolved, Meeting, Opponents
from coevo_manager.core.evolution.optimizer import Optimizer
from coevo_manager.core.evolution.randomness import generator
from coevo_manager.core.evolution.state import fitness_of

SHARE = 0.8
"""Share of its generations left that a lineage is asked for at once, ..."""

SHORTEST_SHARE = 20
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
    agents : Agents
    opponents : Opponents
    rivals : float32 (rivals, genes)
        Whom every agent meets when it has evolved: the opposing population.
    noises : sequence of int
        Starts and noise of each generation, see `Batch`.
    """

    number: int
    species: str
    generations: int
    agents: Agents
    opponents: Opponents
    rivals: np.ndarray
    noises: Sequence[int]


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


class _Agent:
    """One agent: what it wants to have played next, and how far it has come."""

    def __init__(
        self, phase: Phase, index: int, kind: type[Optimizer], configuration: Configuration
    ) -> None:
        self.index = index
        self.completed = 0
        self.training = int(phase.agents.training[index])
        self.meetings: list[Meeting] = []
        self._phase = phase
        self._kind = kind
        self._configuration = configuration
        self._reevaluates = configuration.reevaluate_parents
        self._groups = kind.groups(configuration)
        if self._reevaluates:
            self._groups = np.append(self._groups[:1], self._groups)
        self._most = phase.opponents.number * configuration.pair_ticks

    @functools.cached_property
    def optimizer(self) -> Optimizer:
        """What evolves it; made when it is first asked, so that others' work is out by then."""
        phase, index, configuration = self._phase, self.index, self._configuration
        rng = generator(configuration.seed, 'agent', phase.number, index)
        memory = phase.agents.memory[index]
        learned = (memory,) if memory.size else ()
        fitness = self.training / self._most
        return self._kind(phase.agents.genomes[index], fitness, configuration, rng, *learned)

    @property
    def genome(self) -> np.ndarray:
        """The agent as it is now, float32 (genes,)."""
        return self.optimizer.best

    @property
    def evolved(self) -> bool:
        """Whether it has come through all generations."""
        return self.completed == self._phase.generations

    def next_work(self, longest: int) -> Batch | Lineages:
        """Return the next generations, at most so many, or a batch where it has to send one."""
        lineage = self._next_lineage(longest)
        return self._next_batch() if lineage is None else lineage

    def _next_lineage(self, longest: int) -> Lineages | None:
        species, opponents, noises = self._phase.species, self._phase.opponents, self._phase.noises
        if self.evolved or opponents.draw is not None or self._reevaluates:
            return None
        noise = noises[self.completed]
        if noise != noises[-1]:
            return None
        left = self._phase.generations - self.completed
        share = max(math.ceil(left * SHARE), min(SHORTEST_SHARE, left))
        mutations = self.optimizer.mutations(min(share, longest))
        if mutations is None:
            return None
        return Lineages(
            species,
            self.genome[np.newaxis].copy(),
            np.array([fitness_of(species, self.training, self._most)], np.uint64),
            opponents.genomes,
            mutations.redrawn[np.newaxis],
            mutations.genes,
            mutations.values,
            noise,
        )

    def _next_batch(self) -> Batch:
        """Return the candidates of one generation or, evolved, the agent against its rivals."""
        species, opponents = self._phase.species, self._phase.opponents
        if self.evolved:
            return all_pairs(species, self.genome[np.newaxis], self._phase.rivals)
        if opponents.draw is not None:
            return self._against_drawn(opponents.draw)
        noise = self._phase.noises[self.completed]
        return all_pairs(species, self._candidates(), opponents.genomes, noise)

    def _candidates(self) -> np.ndarray:
        """Return the genomes of the next generation, the agent itself first where it is due."""
        asked = self.optimizer.ask()
        return np.concatenate((self.genome[np.newaxis], asked)) if self._reevaluates else asked

    def _against_drawn(self, draw: Draw) -> Batch:
        """Return the candidates of one generation against the opponents drawn for each."""
        drawn = draw(self.index, self.completed, int(self._groups.max()) + 1)
        self._met = drawn[self._groups]
        used, opponent = np.unique(self._met, return_inverse=True)
        candidate = np.repeat(np.arange(len(self._met), dtype=np.uint32), self._met.shape[1])
        return some_pairs(
            self._phase.species,
            self._candidates(),
            self._phase.opponents.genomes[used],
            candidate,
            opponent.ravel().astype(np.uint32),
            self._phase.noises[self.completed],
        )

    def take(self, capture_ticks: np.ndarray, journal: _Journal) -> None:
        """Go on by the generations whose episodes were played."""
        species, opponents = self._phase.species, self._phase.opponents
        episodes = capture_ticks.reshape(-1, len(self._groups), opponents.number)
        totals = episodes.sum(axis=2, dtype=np.int64)
        accepted, best = [], []
        for fitness in fitness_of(species, totals, self._most) / self._most:
            if self._reevaluates:
                self.optimizer.best_fitness, fitness = float(fitness[0]), fitness[1:]
            accepted.append(self.optimizer.tell(fitness))
            best.append(self.optimizer.best_fitness)
        if opponents.draw is not None:
            self.meetings.append(Meeting(self.genome.copy(), self._met, episodes[0]))
        self.training = round(self.optimizer.best_fitness * self._most)
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
        if completed == self._told:
            return
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
    kind = optimizers.load(configuration.optimizer)
    agents = [
        _Agent(phase, index, kind, configuration) for index in range(len(phase.agents.genomes))
    ]
    journal = _Journal(phase.generations, len(agents))
    capture_ticks = np.empty((len(agents), len(phase.rivals)), np.int32)
    idle = agents.copy()
    running: dict[int, list[_Agent]] = {}
    while idle or running:
        while idle and len(running) < evaluator.slots:
            crew, work = _next_crew(idle, len(running), evaluator)
            running[evaluator.submit(work)] = crew
        ticket, ticks = next_answer(evaluator, stop)
        crew = running.pop(ticket)
        for agent, ours in zip(crew, ticks.reshape(len(crew), -1), strict=True):
            if agent.evolved:
                capture_ticks[agent.index] = ours
            else:
                agent.take(ours, journal)
                idle.append(agent)
        journal.tell(min(agent.completed for agent in agents), on_generation)
    remembered = phase.agents.memory.shape[1]
    return Evolved(
        np.array([agent.genome for agent in agents]),
        np.array([agent.training for agent in agents]),
        capture_ticks,
        np.array([agent.optimizer.memory[:remembered] for agent in agents]),
        np.array([agent.optimizer.position for agent in agents]),
        [agent.meetings for agent in agents],
    )


def _next_crew(
    idle: list[_Agent], running: int, evaluator: Evaluator
) -> tuple[list[_Agent], Batch | Lineages]:
    """Take those that are next from the idle ones, and return them and their work.

    A request costs as much as many episodes. Agents that are equally far therefore ask together,
    so many that half of the slots are in use and no evaluator waits.
    """
    completed, longest = min(agent.completed for agent in idle), evaluator.longest_lineage
    first, *others = (agent for agent in idle if agent.completed == completed)
    work = first.next_work(longest)
    share = math.ceil(len(idle) / max(1, evaluator.slots // 2 - running))
    if isinstance(work, Lineages):
        most = min(share, longest // work.redrawn.size)
    else:
        most = min(share, longest, LONGEST_BATCH // len(work))
    crew = [first, *others[: max(0, most - 1)]]
    for agent in crew:
        idle.remove(agent)
    return crew, joined([work, *(agent.next_work(longest) for agent in crew[1:])])

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
    agents : int
        Agents that have completed it.
    """

    fitness: np.ndarray
    accepted: int = 0
    ticks: int = 0
    agents: int = 0


class _Group:
    """Some agents of a phase, whose candidates are evaluated in one batch.

    A batch may look ahead: it then holds the candidates of several generations of each agent, as
    they are if none before them is accepted. Those after an accepted one are dropped, and asked
    for again as they really are, so that looking ahead changes no result.
    """

    def __init__(
        self, phase: Phase, members: np.ndarray, agents: list[Optimizer], episode_ticks: int
    ) -> None:
        self._phase = phase
        self._episode_ticks = episode_ticks
        self._agents = {int(member): agents[member] for member in members}
        self._completed = dict.fromkeys(self._agents, 0)
        self._accepted = dict.fromkeys(self._agents, 0)
        self._asked: dict[int, int] = {}

    def ask(self, lookahead: int) -> Batch | None:
        """Return the next candidates against the opponents; None when the phase is over.

        Each agent looks ahead, up to `lookahead` generations, about a quarter of the way to its
        next success at the rate of this phase: an eighth of what it asks for is then in vain.
        """
        self._asked = {
            member: min(
                lookahead,
                1 + completed // (1 + 4 * self._accepted[member]),
                self._phase.generations - completed,
            )
            for member, completed in self._completed.items()
            if completed < self._phase.generations
        }
        if not self._asked:
            return None
        candidates = [self._agents[m].ask_ahead(count) for m, count in self._asked.items()]
        self._asked = dict(zip(self._asked, map(len, candidates), strict=True))
        genomes = np.concatenate(candidates).reshape(-1, candidates[0].shape[-1])
        opponents = self._phase.opponents
        index = np.indices((len(genomes), len(opponents)), np.uint32).reshape(2, -1)
        ours, theirs = (genomes, index[0]), (opponents, index[1])
        predator, prey = (ours, theirs) if self._phase.species == 'predator' else (theirs, ours)
        return Batch(predator[0], prey[0], predator[1], prey[1])

    def tell(self, capture_ticks: np.ndarray, records: list[Generation]) -> None:
        """Give each optimizer its candidates' fitness and record the outcome."""
        steps = sum(self._asked.values())
        opponents = len(self._phase.opponents)
        totals = capture_ticks.reshape(steps, -1, opponents).sum(axis=2, dtype=np.int64)
        most = opponents * self._episode_ticks
        fitness = fitness_of(self._phase.species, totals, most) / most
        ticks = totals.sum(axis=1).tolist()
        first = 0
        for member, count in self._asked.items():
            agent = self._agents[member]
            for step in range(first, first + count):
                record = records[self._completed[member]]
                accepted = agent.tell(fitness[step])
                record.accepted += accepted
                record.fitness[member] = agent.best_fitness
                record.ticks += ticks[step]
                record.agents += 1
                self._completed[member] += 1
                self._accepted[member] += accepted
                if accepted:
                    break
            first += count


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
        _Group(phase, members, agents, configuration.episode_ticks)
        for members in np.array_split(np.arange(len(agents)), min(evaluator.slots, len(agents)))
    ]
    records = [Generation(np.empty(len(agents))) for _ in range(phase.generations)]
    reported = 0
    lookahead = evaluator.lookahead
    running: dict[int, _Group] = {}

    def submit(group: _Group) -> None:
        if (batch := group.ask(lookahead)) is not None:
            running[evaluator.submit(batch)] = group

    for group in groups:
        submit(group)
    while running:
        ticket, ticks = next_answer(evaluator, stop)
        group = running.pop(ticket)
        group.tell(ticks, records)
        submit(group)
        while reported < len(records) and records[reported].agents == len(agents):
            on_generation(records[reported])
            reported += 1
    genomes = np.array([agent.best for agent in agents])
    training = np.array([round(agent.best_fitness * most) for agent in agents])
    return genomes, training

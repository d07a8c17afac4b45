"""The pool of evaluators: an `Evaluator` of the core whose nodes may fail, hang or lie."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.node import Node

from coevo_manager.core.environment import Environment
from coevo_manager.core.evaluation import Batch, Lineages, StoppedError, longest_lineage
from coevo_manager.evaluators.client import EvaluatorClient, Question, Replay, Trial
from coevo_manager.evaluators.messages import to_environment_message
from coevo_manager.evaluators.proof import fault, sample
from coevo_manager.evaluators.roster import EvaluationError, Roster
from coevo_manager.evaluators.work_queue import Part, WorkQueue

REQUESTS_EACH = 4
"""Requests under way to each evaluator: so many lineages keep its lanes full, while an answer
travels too."""

LONGEST_COMPILATION = 180.0
"""Longest wait for the first answer of an evaluator that was found, s."""

LONGEST_WAIT = 0.1
"""How long answers are awaited at a stretch, s."""

TRIAL_SHARE = 1 / 50
"""Probability with which an evaluator that gets work plays the known episodes once more."""

MOST_REFUSALS = 3
"""Own evaluators that may answer the same work badly."""


class RosEvaluator:
    """Plays batches on evaluator nodes; an `Evaluator` of the core.

    Work goes to whoever is free. When an evaluator ends, hangs or is late, its work goes to
    another and a late answer changes nothing; the run's own evaluators are started again. When
    none is left, the run waits until one comes.

    No evaluator is trusted. Whoever joins first plays episodes whose results are known, and plays
    them again now and then. Of each answer of an evaluator that is not the run's own, one episode,
    drawn at random, is played again by one that is, before the answer is used. Who answers badly
    is refused, and its work goes to another.

    Parameters
    ----------
    node : Node
        It is not spun; this class waits for its own clients.
    environment : Environment
    own : int
        Evaluator processes to start; with 0 those that already run are used, and one is started
        that plays nothing but samples of their answers. Public evaluators are used in any case,
        from the moment they are found.
    log : callable
        Called with one sentence when something happens to an evaluator.
    patience : float
        The shortest time after which an evaluator counts as late, s; at least ten times what is
        expected of it, from its answers so far.
    """

    def __init__(
        self,
        node: Node,
        environment: Environment,
        own: int,
        log: Callable[[str], None],
        patience: float = 5.0,
    ) -> None:
        self.environment = environment
        self.longest_lineage = longest_lineage(environment)
        self._own = own
        message = to_environment_message(environment)
        self._roster = Roster(node, message, own, log, patience, self._put_back)
        self._queue = WorkQueue()
        self._replays: collections.deque[Replay] = collections.deque()
        self._rng = np.random.default_rng()  # what it decides changes no result

    @property
    def slots(self) -> int:
        """Batches and lineages worth keeping submitted at once."""
        return REQUESTS_EACH * max(self.evaluators, self._own, 1)

    @property
    def evaluators(self) -> int:
        """Evaluators at work at the moment."""
        return len(self._roster.players)

    def describe(self) -> dict[str, Any]:
        """Return who is there, how busy each was lately, and who failed, for JSON."""
        return self._roster.describe()

    def start(self, stop: threading.Event, timeout: float | None = None) -> None:
        """Wait for the first evaluator.

        Raises
        ------
        EvaluationError
            The own evaluators end at once, or none other answered within `timeout` seconds; one
            that was found and may be compiling is waited for longer.
        StoppedError
            `stop` was set.
        """
        deadline = None
        while not self.evaluators:
            if stop.is_set():
                raise StoppedError
            if deadline is None and timeout is not None and self._roster.known:
                deadline = time.monotonic() + timeout
            late = 0.0 if deadline is None else time.monotonic() - deadline
            if late > (LONGEST_COMPILATION if self._roster.on_trial else 0.0):
                raise EvaluationError(
                    f'no evaluator answered within {timeout:g} s; start some with '
                    '"coevo_manager evaluator", or let evolve start its own'
                )
            self._turn(LONGEST_WAIT)

    def submit(self, work: Batch | Lineages) -> int:
        """Take a batch or lineages and return its ticket at once."""
        ticket = self._queue.submit(work)
        self._dispatch()
        return ticket

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Wait for any submitted work; None when the time is over or nothing was submitted.

        Raises
        ------
        EvaluationError
            Evaluators keep answering the same work badly, or the own ones cannot be started.
        """
        deadline = float('inf') if timeout is None else time.monotonic() + timeout
        while (finished := self._queue.finished()) is None and self._queue.unfinished:
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._turn(min(left, LONGEST_WAIT))
            self._roster.say_if_alone()
        return finished

    def cancel(self) -> None:
        """Forget all submitted work."""
        self._queue.cancel()
        self._replays.clear()

    def close(self) -> None:
        """Leave all evaluators, and end the own ones."""
        self._roster.close()

    def _turn(self, timeout: float) -> None:
        """Take what was answered and pass work on."""
        for client, question, response in self._roster.wait(timeout):
            if client.refused:
                self._put_back([question])
            else:
                self._receive(client, question, response)
        self._dispatch()

    def _dispatch(self) -> None:
        judges = self._roster.judges
        while self._replays and judges:
            min(judges, key=len).send(self._replays.popleft())
        players = self._roster.players
        while free := [client for client in players if len(client) < REQUESTS_EACH]:
            part = self._queue.take()
            if part is None:
                return
            client = min(free, key=lambda client: client.episodes)
            if self._rng.random() < TRIAL_SHARE:
                client.send(self._roster.trial)
            client.send(part)

    def _receive(self, client: EvaluatorClient, question: Question, response: Any) -> None:
        ticks = np.frombuffer(response.capture_ticks, np.int32)
        length = self.environment.episode_ticks
        reason = fault(question.work, response.success, response.message, ticks, length)
        if not reason and isinstance(question, Trial):
            reason = self._roster.judge(client, ticks)
        if reason:
            self._refuse(client, question, reason)
        elif isinstance(question, Replay):
            self._take_replay(question, int(ticks[0]))
        elif isinstance(question, Part):
            if client.process is not None:
                self._use(client, question, ticks)
            elif self._queue.wanted(question):
                replay = sample(question.work, ticks, self._rng)
                self._replays.append(Replay(*replay, client, question, ticks))

    def _use(self, client: EvaluatorClient, part: Part, ticks: np.ndarray) -> None:
        client.used += 1
        self._queue.accept(part, ticks)

    def _take_replay(self, replay: Replay, tick: int) -> None:
        author = replay.author
        if author.refused:
            self._put_back([replay])
        elif tick == replay.tick:
            self._use(author, replay.part, replay.ticks)
        else:
            reason = f'answered tick {replay.tick} for an episode that ends at tick {tick}'
            self._refuse(author, replay.part, reason)

    def _refuse(self, client: EvaluatorClient, question: Question, reason: str) -> None:
        """Drop an evaluator that has answered badly, and with it all that was not proved."""
        if isinstance(question, Part) and client.process is not None:
            question.refusals += 1
            if question.refusals >= MOST_REFUSALS:
                raise EvaluationError(
                    f'{MOST_REFUSALS} own evaluators answered the same work badly; the last one '
                    f'{reason}'
                )
        self._roster.refuse(client, reason)
        unproved = [replay for replay in self._replays if replay.author is client]
        for replay in unproved:
            self._replays.remove(replay)
        self._put_back([question, *unproved])

    def _put_back(self, questions: list[Question]) -> int:
        """Let others do what an evaluator did not do, before all else; return how many parts."""
        parts = []
        for question in questions:
            if isinstance(question, Part):
                parts.append(question)
            elif isinstance(question, Replay):
                if question.author.refused:
                    parts.append(question.part)
                else:
                    self._replays.appendleft(question)
        return self._queue.give_back(parts)

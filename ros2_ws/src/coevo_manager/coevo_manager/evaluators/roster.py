"""The evaluators of a run: who is there, who is admitted, who has to go."""

from __future__ import annotations

import collections
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from coevo_msgs.msg import Environment as EnvironmentMsg
from rclpy.client import Client
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node

from coevo_manager.evaluators.client import EvaluatorClient, Question, Trial
from coevo_manager.evaluators.process import END_TIMEOUT, OWN_PREFIX, EvaluatorProcess
from coevo_manager.evaluators.proof import known_episodes
from neuro_controller.core.genome import Layout
from node_runner.children import end_all

SERVICE_TYPE = 'coevo_msgs/srv/EvaluateBatch'

CHECK_PERIOD = 0.1
"""How often processes and the clock are looked at, s."""

DISCOVERY_PERIOD = 1.0
"""How often new evaluators are looked for, s."""

MOST_FAILURES = 3
"""Own evaluators that may fail, one after the other, before any was admitted."""

LOSSES_TOLD = 20
"""So many of the evaluators that failed last are described."""

LONGEST_PAUSE = 10.0
"""Longest pause before another own evaluator is started where they keep failing, s."""


class EvaluationError(Exception):
    """No evaluator can play the episodes; one sentence that says why."""


class Roster:
    """Starts the run's own evaluators, finds others, and drops those that end, hang or are late.

    Parameters
    ----------
    node : Node
        It is not spun; `wait` waits for its clients.
    environment : coevo_msgs/Environment
        Where every episode is played.
    own : int
        Evaluator processes that play; with 0 one is started that only judges others.
    log : callable
        Called with one sentence when something happens to an evaluator.
    patience : float
        The shortest time after which an evaluator counts as late, s.
    on_loss : callable
        Called with the questions that an evaluator will not answer; returns how much work goes to
        another for it.

    Attributes
    ----------
    clients : list of EvaluatorClient
    trial : Trial
        The known episodes.
    known : bool
        Whether their results are known: the first own evaluator tells them.
    """

    def __init__(
        self,
        node: Node,
        environment: EnvironmentMsg,
        own: int,
        log: Callable[[str], None],
        patience: float,
        on_loss: Callable[[list[Question]], int],
    ) -> None:
        self.clients: list[EvaluatorClient] = []
        self.trial = Trial(known_episodes(Layout(environment.hidden)))
        self._trial_ticks: np.ndarray | None = None
        self._node = node
        self._environment = environment
        self._own = own
        self._log = log
        self._patience = patience
        self._on_loss = on_loss
        self._services: list[tuple[EvaluatorClient, Client]] = []
        self._wait_set: _rclpy.WaitSet | None = None
        self._failures = 0
        self._refused: set[str] = set()
        self._losses: collections.deque[dict[str, Any]] = collections.deque(maxlen=LOSSES_TOLD)
        self._alone = False
        self._next_check = self._next_discovery = self._next_start = 0.0

    @property
    def known(self) -> bool:
        """See the class."""
        return self._trial_ticks is not None

    @property
    def on_trial(self) -> bool:
        """Whether an evaluator of somebody else's is at work on the known episodes."""
        return any(c.process is None and not c.admitted and len(c) for c in self.clients)

    @property
    def players(self) -> list[EvaluatorClient]:
        """Evaluators that get work."""
        return [c for c in self.clients if c.admitted and (self._own or c.process is None)]

    @property
    def judges(self) -> list[EvaluatorClient]:
        """Own evaluators, which play samples of the others' answers again."""
        return [c for c in self.clients if c.admitted and c.process is not None]

    def wait(self, timeout: float) -> list[tuple[EvaluatorClient, Question, Any]]:
        """Look after the evaluators, then wait for answers.

        Returns
        -------
        list of (client, question, response)

        Raises
        ------
        EvaluationError
            The own evaluators cannot be started.
        """
        now = time.monotonic()
        if now >= self._next_check:
            self._next_check = now + CHECK_PERIOD
            for client in self.clients.copy():
                self._check(client, now)
            self._complete(now)
        if self._wait_set is None or not self._services:  # an empty set cannot be waited for
            time.sleep(timeout)
            return []
        self._wait_set.clear_entities()
        for _, service in self._services:
            self._wait_set.add_client(service.handle)
        self._wait_set.wait(int(timeout * 1e9))
        ready = [s for i, s in enumerate(self._services) if self._wait_set.is_ready('client', i)]
        answers = [(client, client.take(service)) for client, service in ready]
        return [(client, *answer) for client, answer in answers if answer is not None]

    def judge(self, client: EvaluatorClient, ticks: np.ndarray) -> str:
        """Admit an evaluator that has played the known episodes as the first one did.

        It plays them twice: the first answer waits for its simulation to be compiled, and only
        from the second it is known how fast it plays, and so when it is late.

        Returns
        -------
        str
            What it did wrong, as `coevo_manager.evaluators.proof.fault` tells it; '' if nothing.
        """
        if self._trial_ticks is None:
            self._trial_ticks = ticks.copy()
        if not np.array_equal(ticks, self._trial_ticks):
            return 'plays known episodes otherwise than the first evaluator did'
        if not client.admitted and not client.measured:
            client.send(self.trial)
        elif not client.admitted:
            client.admitted = True
            self._welcome(client)
        return ''

    def refuse(self, client: EvaluatorClient, reason: str) -> None:
        """Drop an evaluator that has answered badly.

        Raises
        ------
        EvaluationError
            It is the run's own and answers nothing rightly.
        """
        if client.process is not None and not self.known:
            raise EvaluationError(f'{client.service} cannot play the episodes: it {reason}')
        client.refused = True
        reason = f'is refused: it {reason}; {client.used} answers of it were used before'
        if client.process is not None:
            self._fail(client, reason, time.monotonic())
        else:
            self._refused.add(client.service)
            self._drop(client, reason)

    def say_if_alone(self) -> None:
        """Tell, once, that there is work and nobody to do it."""
        if not self.players and not self._alone:
            self._alone = True
            self._log('no evaluator is left; the run waits for one')

    def describe(self) -> dict[str, Any]:
        """Return who is there, how busy each was lately, and who failed, for JSON."""
        return {
            'evaluators': [client.describe() for client in self.clients],
            'losses': list(self._losses),
        }

    def close(self) -> None:
        """Leave all evaluators, and end the own ones."""
        end_all([c.process for c in self.clients if c.process is not None], END_TIMEOUT)
        for client in self.clients:
            client.destroy()
        self.clients.clear()

    def _welcome(self, client: EvaluatorClient) -> None:
        if self._alone or client.process is None or self._failures:
            self._log(f'evaluator {client.service} joined')
        elif 1 < self._own == len(self.judges):
            self._log(f'all {self._own} evaluators are at work')
        self._failures = 0
        self._alone = self._alone and not self.players

    def _check(self, client: EvaluatorClient, now: float) -> None:
        """Notice that an evaluator ended, went away or is late; ask it what is due."""
        ending = client.process and client.process.ending()
        if ending:
            self._fail(client, f'ended {ending}', now)
        elif client.late(now):
            if client.process is not None:
                self._fail(client, 'is late and was ended', now)
            else:
                self._give_away(client, 'is late')
        elif client.gone():
            self._drop(client, 'is gone')
        elif not client.admitted and not len(client) and client.present():
            client.send(self.trial)
        else:
            client.repeat(now)

    def _complete(self, now: float) -> None:
        """Start own evaluators and find others."""
        # The first one compiles, if need be, for those that are started when it is ready.
        wanted = max(self._own, 1) if self.known else 1
        own = sum(client.process is not None for client in self.clients)
        while own < wanted and now >= self._next_start:
            try:
                process = EvaluatorProcess()
            except OSError as error:
                raise EvaluationError(f'an evaluator cannot be started: {error}') from None
            self._add(process.service, process)
            own += 1
        if self.known and now >= self._next_discovery:
            self._next_discovery = now + DISCOVERY_PERIOD
            present = {client.service for client in self.clients}
            for service, types in self._node.get_service_names_and_types():
                public = SERVICE_TYPE in types and not service.startswith(OWN_PREFIX)
                if public and service not in present | self._refused:
                    self._add(service, None)

    def _add(self, service: str, process: EvaluatorProcess | None) -> None:
        client = EvaluatorClient(self._node, service, self._environment, self._patience, process)
        self._set_clients([*self.clients, client])

    def _fail(self, client: EvaluatorClient, reason: str, now: float) -> None:
        """Drop an own evaluator that failed; another is started in its place, soon."""
        self._failures += 1
        self._drop(client, reason)
        if not self.known and self._failures >= MOST_FAILURES:
            raise EvaluationError(f'evaluators cannot be started: the last one {reason}')
        if self._failures > 1:
            self._next_start = now + min(LONGEST_PAUSE, 0.25 * 2**self._failures)

    def _drop(self, client: EvaluatorClient, reason: str) -> None:
        self._give_away(client, reason)
        self._set_clients([other for other in self.clients if other is not client])
        client.destroy()

    def _give_away(self, client: EvaluatorClient, reason: str) -> None:
        """Let others do the work of an evaluator."""
        count = self._on_loss(client.give_away())
        work = f'; its work ({count} requests) goes to another' if count else ''
        self._losses.append({'time': time.time(), 'service': client.service, 'reason': reason})
        self._log(f'evaluator {client.service} {reason}{work}')

    def _set_clients(self, clients: list[EvaluatorClient]) -> None:
        self.clients = clients
        self._services = [(client, service) for client in clients for service in client.clients]
        context = self._node.context.handle
        self._wait_set = _rclpy.WaitSet(0, 0, 0, len(self._services), 0, 0, context)

"""Evaluators reached through ROS services, any of which may fail."""

from __future__ import annotations

import collections
import itertools
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.client import Client
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node

from coevo_manager.core.environment import Environment
from coevo_manager.core.evaluation import Batch, Lineage, StoppedError, longest_lineage
from coevo_manager.evaluators.client import EvaluatorClient, Part, split
from coevo_manager.evaluators.messages import to_environment_message
from coevo_manager.evaluators.process import OWN_PREFIX, EvaluatorProcess
from neuro_controller.core.genome import random_genomes

SERVICE_TYPE = 'coevo_msgs/srv/EvaluateBatch'

PART_EPISODES = 256
"""Most episodes of one request: larger batches are shared by all evaluators."""

REQUESTS_EACH = 4
"""Requests under way to each evaluator: so many lineages keep its lanes full, while an answer
travels too."""

CHECK_PERIOD = 0.1
"""How often processes and the clock are looked at, s."""

DISCOVERY_PERIOD = 1.0
"""How often new evaluators are looked for, s."""

MOST_FAILURES = 3
"""Own evaluators that may fail, one after the other, before any was admitted."""

LONGEST_PAUSE = 10.0
"""Longest pause before another own evaluator is started where they keep failing, s."""

TRIAL = 0
"""Ticket of the episodes that an evaluator plays before it is admitted."""

TRIAL_PERIOD = 2.0
"""How often an evaluator is asked for them, s: its first answer is lost where it has not yet
discovered who asks."""


class EvaluationError(Exception):
    """No evaluator can play the episodes; one sentence that says why."""


class RosEvaluator:
    """Plays batches on evaluator nodes; an `Evaluator` of the core.

    Work goes to whoever is free. When an evaluator ends, hangs or is late, its work goes to
    another and a late answer changes nothing; the run's own evaluators are started again. When
    none is left, the run waits until one comes. An evaluator that joins first plays episodes whose
    results are known, and is refused if it plays them otherwise, so that no result depends on who
    played.

    Parameters
    ----------
    node : Node
        It is not spun; this class waits for its own clients.
    environment : Environment
    own : int
        Evaluator processes to start; with 0 those that already run are used. Public evaluators are
        used in any case, from the moment they are found.
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
        self._node = node
        self._own = own
        self._log = log
        self._patience = patience
        self._message = to_environment_message(environment)
        self._clients: list[EvaluatorClient] = []
        self._services: list[tuple[EvaluatorClient, Client]] = []
        self._wait_set: _rclpy.WaitSet | None = None
        self._failures = 0
        self._refused: set[str] = set()
        self._alone = False
        self._next_check = self._next_discovery = self._next_start = 0.0

        self._tickets = itertools.count(TRIAL + 1)
        self._waiting: collections.deque[Part] = collections.deque()
        self._results: dict[int, np.ndarray] = {}
        self._parts_left: dict[int, int] = {}
        self._finished: collections.deque[tuple[int, np.ndarray]] = collections.deque()

        rng = np.random.default_rng(0)
        pairs = np.arange(16, dtype=np.uint32)
        genomes = random_genomes(16, rng), random_genomes(16, rng)
        self._trial = Part(TRIAL, Batch(*genomes, pairs, pairs), slice(0, 16))
        self._trial_ticks: np.ndarray | None = None

    @property
    def slots(self) -> int:
        """Batches and lineages worth keeping submitted at once."""
        return REQUESTS_EACH * max(self.evaluators, self._own, 1)

    @property
    def evaluators(self) -> int:
        """Evaluators at work at the moment."""
        return sum(client.ready for client in self._clients)

    def start(self, stop: threading.Event, timeout: float | None = None) -> None:
        """Wait for the first evaluator.

        Raises
        ------
        EvaluationError
            The own evaluators end at once, or none answered within `timeout` seconds.
        StoppedError
            `stop` was set.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while not self.evaluators:
            if stop.is_set():
                raise StoppedError
            if deadline is not None and time.monotonic() > deadline:
                raise EvaluationError(
                    f'no evaluator answered within {timeout:g} s; start some with '
                    '"coevo_manager evaluator", or let evolve start its own'
                )
            self._turn(0.05)

    def submit(self, work: Batch | Lineage) -> int:
        """Take a batch or a lineage and return its ticket at once."""
        ticket = next(self._tickets)
        parts = list(split(ticket, work, PART_EPISODES))
        self._results[ticket] = np.empty(len(work), np.int32)
        self._parts_left[ticket] = len(parts)
        self._waiting.extend(parts)
        self._dispatch()
        return ticket

    def collect(self, timeout: float | None = None) -> tuple[int, np.ndarray] | None:
        """Wait for any submitted work; None when the time is over or nothing was submitted.

        Raises
        ------
        EvaluationError
            An evaluator refused the work, or the own evaluators cannot be started.
        """
        deadline = float('inf') if timeout is None else time.monotonic() + timeout
        while self._results and not self._finished:
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._turn(min(left, CHECK_PERIOD))
        return self._finished.popleft() if self._finished else None

    def cancel(self) -> None:
        """Forget all submitted work."""
        for part in self._waiting:
            part.done = True
        for client in self._clients:
            for part in client.in_flight.values():
                part.done = True
        self._waiting.clear()
        self._results.clear()
        self._parts_left.clear()
        self._finished.clear()

    def close(self) -> None:
        """Leave all evaluators, and end the own ones."""
        own = [client.process for client in self._clients if client.process is not None]
        EvaluatorProcess.end_all(own)
        for client in self._clients:
            client.destroy()
        self._clients.clear()

    def _turn(self, timeout: float) -> None:
        """Look after the evaluators, then wait for answers and pass work on."""
        now = time.monotonic()
        if now >= self._next_check:
            self._next_check = now + CHECK_PERIOD
            self._check(now)
        if not self._clients:
            time.sleep(timeout)
            return
        self._wait_set.clear_entities()
        for _, client in self._services:
            self._wait_set.add_client(client.handle)
        self._wait_set.wait(int(timeout * 1e9))
        ready = [s for i, s in enumerate(self._services) if self._wait_set.is_ready('client', i)]
        for evaluator, client in ready:
            self._receive(evaluator, evaluator.take(client))
        self._dispatch()

    def _receive(self, client: EvaluatorClient, answer: tuple[Part, Any] | None) -> None:
        if answer is None:
            return
        part, response = answer
        ticks = np.frombuffer(response.capture_ticks, np.int32)
        if part.ticket == TRIAL:
            self._judge(client, response.message, ticks)
            return
        if not response.success or len(ticks) != len(part.work):
            raise EvaluationError(f'{client.service} refused its work: {response.message}')
        part.done = True
        self._results[part.ticket][part.place] = ticks
        self._parts_left[part.ticket] -= 1
        if not self._parts_left[part.ticket]:
            del self._parts_left[part.ticket]
            self._finished.append((part.ticket, self._results.pop(part.ticket)))

    def _judge(self, client: EvaluatorClient, message: str, ticks: np.ndarray) -> None:
        """Admit an evaluator that has played the trial as the first one did."""
        if client.admitted:
            return
        if self._trial_ticks is None and len(ticks):
            self._trial_ticks = ticks
        if self._trial_ticks is not None and np.array_equal(ticks, self._trial_ticks):
            client.admit()
            self._failures = 0
            if self._alone or client.process is None or client.restarted:
                self._log(f'evaluator {client.service} joined')
            self._alone = False
            return
        reason = message or 'it plays known episodes otherwise than the first evaluator did'
        if client.process is not None:
            raise EvaluationError(f'{client.service} cannot play the episodes: {reason}')
        self._refused.add(client.service)
        self._drop(client, f'is not used: {reason}')

    def _dispatch(self) -> None:
        while self._waiting:
            free = [c for c in self._clients if c.ready and len(c.in_flight) < REQUESTS_EACH]
            if not free:
                return
            part = self._waiting.popleft()
            if not part.done:
                min(free, key=lambda client: len(client.in_flight)).send(part)

    def _check(self, now: float) -> None:
        """Notice who ended, went away or is late; start and find others."""
        for client in self._clients.copy():
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
            elif client.on_trial and now >= client.next_trial and client.present():
                client.next_trial = now + TRIAL_PERIOD
                client.send(self._trial)
        own = sum(client.process is not None for client in self._clients)
        while own < self._own and now >= self._next_start:
            process = EvaluatorProcess()
            self._add(process.service, process)
            own += 1
        if now >= self._next_discovery and (not self._own or self._trial_ticks is not None):
            self._next_discovery = now + DISCOVERY_PERIOD
            self._discover()
        if self._results and not self.evaluators and not self._alone:
            self._alone = True
            self._log('no evaluator is left; the run waits for one')

    def _discover(self) -> None:
        known = {client.service for client in self._clients} | self._refused
        for service, types in self._node.get_service_names_and_types():
            public = SERVICE_TYPE in types and not service.startswith(OWN_PREFIX)
            if public and service not in known:
                self._add(service, None)

    def _add(self, service: str, process: EvaluatorProcess | None) -> None:
        client = EvaluatorClient(self._node, service, self._message, self._patience, process)
        client.restarted = self._failures > 0
        self._set_clients([*self._clients, client])

    def _fail(self, client: EvaluatorClient, reason: str, now: float) -> None:
        """Drop an own evaluator that failed; another is started in its place, soon."""
        self._failures += 1
        self._drop(client, reason)
        if self._trial_ticks is None and self._failures >= MOST_FAILURES:
            raise EvaluationError(f'evaluators cannot be started: the last one {reason}')
        if self._failures > 1:
            self._next_start = now + min(LONGEST_PAUSE, 0.25 * 2**self._failures)

    def _drop(self, client: EvaluatorClient, reason: str) -> None:
        self._give_away(client, reason)
        self._set_clients([other for other in self._clients if other is not client])
        client.destroy()

    def _give_away(self, client: EvaluatorClient, reason: str) -> None:
        """Put the work of an evaluator back where the others take it from, first of all."""
        parts = [part for part in client.give_away() if part.ticket != TRIAL]
        self._waiting.extendleft(reversed(parts))
        work = f'; its work ({len(parts)} requests) goes to another' if parts else ''
        self._log(f'evaluator {client.service} {reason}{work}')

    def _set_clients(self, clients: list[EvaluatorClient]) -> None:
        self._clients = clients
        self._services = [(client, service) for client in clients for service in client.clients]
        context = self._node.context.handle
        self._wait_set = _rclpy.WaitSet(0, 0, 0, len(self._services), 0, 0, context)

"""One evaluator as a run sees it: what it was asked, and how long its answers take."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

from coevo_msgs.msg import Environment as EnvironmentMsg
from coevo_msgs.srv import EvaluateBatch, EvaluateLineages
from rclpy.client import Client
from rclpy.node import Node

from coevo_manager.core.evaluation import Batch, Lineages
from coevo_manager.evaluators.load import Load
from coevo_manager.evaluators.messages import Requests
from coevo_manager.evaluators.process import EvaluatorProcess
from coevo_manager.evaluators.work_queue import Part
from node_runner import new_number

START_PATIENCE = 180.0
"""How long an own evaluator may compute to start, and to compile what it runs, s of CPU time."""

START_IDLENESS = 10.0
"""How long an own evaluator that starts may compute nothing, s: then it hangs."""

FIRST_PATIENCE = 30.0
"""How long the first answer of an evaluator may take, s."""

LATENESS = 10.0
"""An evaluator is late when it takes so many times longer than expected."""

FIRST_PAUSE = 1.0
"""How long an answer is awaited before its request is sent again, s; then twice as long."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """Episodes that evaluators are compared by."""

    work: Batch


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Replay:
    """One episode of another's answer, to be played again.

    Attributes
    ----------
    work : Batch
        The episode.
    tick : int
        When it ended, as the other says.
    author : EvaluatorClient
        The other.
    part, ticks
        What it was asked, and its answer.
    """

    work: Batch
    tick: int
    author: EvaluatorClient
    part: Part
    ticks: Any


Question = Part | Trial | Replay


@dataclasses.dataclass(slots=True)
class _Asked:
    """A question that is under way: when it is sent again, and after what pause then."""

    question: Question
    again: float
    pause: float = FIRST_PAUSE


class EvaluatorClient:
    """The requests that are under way to one evaluator; each is repeated until it is answered.

    Parameters
    ----------
    node : Node
    service : str
        Full name of the evaluator's service ``evaluate_batch``.
    environment : coevo_msgs/Environment
        Where every episode is played.
    patience : float
        The shortest time after which an evaluator counts as late, s.
    process : EvaluatorProcess, optional
        The process, if it is the run's own.

    Attributes
    ----------
    clients : tuple
        rclpy's clients of its services.
    admitted : bool
        It has proved that it plays episodes as the others do, and is not late.
    refused : bool
        It has answered badly.
    used : int
        How many of its answers were used.
    """

    def __init__(
        self,
        node: Node,
        service: str,
        environment: EnvironmentMsg,
        patience: float,
        process: EvaluatorProcess | None = None,
    ) -> None:
        self.service = service
        self.process = process
        self.admitted = False
        self.refused = False
        self.used = 0
        self._warm = False
        self._node = node
        self._requests = Requests(environment)
        self._patience = patience
        self._batches = node.create_client(EvaluateBatch, service)
        self._lineages = node.create_client(
            EvaluateLineages, service.removesuffix('batch') + 'lineages'
        )
        self.clients = self._batches, self._lineages
        self._in_flight: dict[int, _Asked] = {}
        self._given_away: dict[int, _Asked] = {}
        self._seen = False
        self._last_event = time.monotonic()
        self._load = Load(self._last_event)
        self._episode_seconds: float | None = None

    def __len__(self) -> int:
        """Return how many requests are under way."""
        return len(self._in_flight)

    @property
    def episodes(self) -> int:
        """Episodes that it was asked for and has not answered."""
        return sum(len(asked.question.work) for asked in self._in_flight.values())

    @property
    def measured(self) -> bool:
        """Whether it is known how fast it plays."""
        return self._episode_seconds is not None

    def present(self) -> bool:
        """Whether its services are there, as far as discovery knows."""
        present = all(client.service_is_ready() for client in self.clients)
        self._seen = self._seen or present
        return present

    def gone(self) -> bool:
        """Whether its services were there and are no more."""
        return self._seen and not self.present()

    def send(self, question: Question) -> None:
        """Ask it something."""
        now = time.monotonic()
        if not self._in_flight:
            self._last_event = now
        self._load.busy(now, True)
        number = new_number()
        self._in_flight[number] = _Asked(question, now + FIRST_PAUSE)
        self._request(number, question)

    def repeat(self, now: float) -> None:
        """Ask again what was not answered for long."""
        for number, asked in self._in_flight.items():
            if now >= asked.again:
                asked.pause *= 2
                asked.again = now + asked.pause
                self._request(number, asked.question)

    def _request(self, number: int, question: Question) -> None:
        client = self._lineages if isinstance(question.work, Lineages) else self._batches
        client.handle.send_request(self._requests.fill(question.work, number))

    def take(self, client: Client) -> tuple[Question, Any] | None:
        """Return an answer that has arrived and what it answers; None if nobody waits for it."""
        _, response = client.handle.take_response(client.srv_type.Response)  # type: ignore[attr-defined]
        if response is None:
            return None
        now = time.monotonic()
        asked = self._in_flight.pop(response.number, None)
        if asked is None:
            asked = self._given_away.pop(response.number, None)
        elif self._warm:  # the first answer tells how long compiling took
            seconds = (now - self._last_event) / max(len(asked.question.work), 1)
            known = self._episode_seconds
            self._episode_seconds = seconds if known is None else 0.9 * known + 0.1 * seconds
        self._warm = True
        self._last_event = now
        self._load.busy(now, bool(self._in_flight))
        self._load.episodes += 0 if asked is None else len(asked.question.work)
        return None if asked is None else (asked.question, response)

    def late(self, now: float) -> bool:
        """Whether it has been silent for too long although it was asked, or hangs at its start."""
        if not self.admitted:
            return self.process is not None and (
                self.process.idle_seconds() > START_IDLENESS
                or self.process.cpu_seconds > START_PATIENCE
            )
        if not self._in_flight:
            return False
        if self._episode_seconds is None:
            return now - self._last_event > max(FIRST_PATIENCE, self._patience)
        expected = self.episodes * self._episode_seconds
        return now - self._last_event > max(self._patience, LATENESS * expected)

    def give_away(self) -> list[Question]:
        """Return the unanswered questions, for another evaluator.

        This one gets no more work until it proves itself again; a late answer still counts.
        """
        questions = [asked.question for asked in self._in_flight.values()]
        self._given_away |= self._in_flight
        self._in_flight = {}
        self._load.busy(time.monotonic(), False)
        self.admitted = False
        return questions

    def describe(self) -> dict[str, Any]:
        """Return what it is and what it did since this was asked last, for JSON."""
        share, rate = self._load.since_last(time.monotonic())
        return {
            'service': self.service,
            'process': None if self.process is None else self.process.pid,
            'working': self.admitted,
            'requests': len(self),
            'busy': round(share, 3),
            'episodes_per_second': round(rate, 1),
        }

    def destroy(self) -> None:
        """Leave the service, and end its process if it is the run's own."""
        for client in self.clients:
            self._node.destroy_client(client)
        if self.process is not None:
            self.process.end_at_once()

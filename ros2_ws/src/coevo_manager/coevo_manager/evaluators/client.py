"""One evaluator as a run sees it: what it was asked, and how long its answers take."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from coevo_msgs.msg import Environment as EnvironmentMsg
from coevo_msgs.srv import EvaluateBatch, EvaluateLineage
from rclpy.client import Client
from rclpy.node import Node

from coevo_manager.core.evaluation import Batch, Lineage
from coevo_manager.evaluators.messages import to_request
from coevo_manager.evaluators.process import EvaluatorProcess

START_PATIENCE = 180.0
"""How long an own evaluator may take to start, and to compile what it runs, s."""

FIRST_PATIENCE = 30.0
"""How long the first answer of an evaluator may take, s."""

LATENESS = 10.0
"""An evaluator is late when it takes so many times longer than expected."""


_Key = tuple[Client, int]


@dataclasses.dataclass(eq=False, slots=True)
class Part:
    """What one request asks: a share of a batch, or a lineage.

    Attributes
    ----------
    ticket : int
        Ticket of the batch or lineage.
    work : Batch or Lineage
        The episodes, with the genomes that they need.
    place : slice
        Where their results lie in those of the ticket.
    done : bool
        Answered, or not wanted any more: further answers are ignored.
    """

    ticket: int
    work: Batch | Lineage
    place: slice
    done: bool = False


class EvaluatorClient:
    """The requests that are under way to one evaluator.

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
    in_flight : dict
        Parts by client and sequence number of the request, oldest first.
    admitted : bool
        It has proved that it plays episodes as the others do.
    restarted : bool
        It takes the place of one that failed.
    next_trial : float
        When it is asked to prove itself, by the monotonic clock, s.
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
        self.restarted = False
        self.next_trial = 0.0
        self.in_flight: dict[_Key, Part] = {}
        self._node = node
        self._environment = environment
        self._patience = patience
        self._batches = node.create_client(EvaluateBatch, service)
        self._lineages = node.create_client(
            EvaluateLineage, service.removesuffix('batch') + 'lineage'
        )
        self.clients = self._batches, self._lineages
        self._given_away: dict[_Key, Part] = {}
        self._silent = False
        self._seen = False
        self._last_event = time.monotonic()
        self._episode_seconds: float | None = None

    @property
    def ready(self) -> bool:
        """Whether it gets work."""
        return self.admitted and not self._silent

    @property
    def on_trial(self) -> bool:
        """Whether it was not admitted yet, and is not late with its trial."""
        return not self.admitted and not self._silent

    def present(self) -> bool:
        """Whether its services are there, as far as discovery knows."""
        present = all(client.service_is_ready() for client in self.clients)
        self._seen = self._seen or present
        return present

    def gone(self) -> bool:
        """Whether its services were there and are no more."""
        return self._seen and not self.present()

    def admit(self) -> None:
        """Give it work from now on; what it was asked before need not be answered."""
        self.admitted = True
        self.in_flight = {}

    def send(self, part: Part) -> None:
        """Ask for a part."""
        client = self._lineages if isinstance(part.work, Lineage) else self._batches
        request = to_request(part.work, self._environment)
        if not self.in_flight:
            self._last_event = time.monotonic()
        self.in_flight[client, client.handle.send_request(request)] = part

    def take(self, client: Client) -> tuple[Part, Any] | None:
        """Return an answer that has arrived and what it answers; None if nobody waits for it."""
        header, response = client.handle.take_response(client.srv_type.Response)
        if response is None:
            return None
        self._silent = False
        key = client, header.request_id.sequence_number
        now = time.monotonic()
        part = self.in_flight.pop(key, None)
        if part is not None:
            seconds = (now - self._last_event) / max(len(part.work), 1)
            known = self._episode_seconds
            self._episode_seconds = seconds if known is None else 0.9 * known + 0.1 * seconds
        else:
            part = self._given_away.pop(key, None)
        self._last_event = now
        return None if part is None or part.done else (part, response)

    def late(self, now: float) -> bool:
        """Whether it has been silent for too long although it was asked."""
        if not self.in_flight:
            starting = self.process is not None and not self.admitted
            return starting and now - self._last_event > START_PATIENCE
        if self._episode_seconds is None:
            return now - self._last_event > max(FIRST_PATIENCE, self._patience)
        episodes = sum(len(part.work) for part in self.in_flight.values())
        expected = episodes * self._episode_seconds
        return now - self._last_event > max(self._patience, LATENESS * expected)

    def give_away(self) -> list[Part]:
        """Return the unanswered parts, for another evaluator.

        This one gets no more work until it answers; a late answer still counts.
        """
        parts = [part for part in self.in_flight.values() if not part.done]
        self._given_away = self._given_away | self.in_flight
        self.in_flight = {}
        self._silent = True
        return parts

    def destroy(self) -> None:
        """Leave the service, and kill its process if it is the run's own."""
        for client in self.clients:
            self._node.destroy_client(client)
        if self.process is not None:
            self.process.kill()


def split(ticket: int, work: Batch | Lineage, longest: int) -> Iterator[Part]:
    """Divide a batch into parts of at most `longest` episodes, as equal as can be.

    A lineage stays whole.
    """
    if isinstance(work, Lineage):
        yield Part(ticket, work, slice(0, len(work)))
        return
    batch = work
    count = -(-len(batch) // longest)
    if count <= 1:
        yield Part(ticket, batch, slice(0, len(batch)))
        return
    bounds = np.linspace(0, len(batch), count + 1).round().astype(int)
    for first, end in itertools.pairwise(bounds):
        place = slice(int(first), int(end))
        predators, predator_index = np.unique(batch.predator_index[place], return_inverse=True)
        prey, prey_index = np.unique(batch.prey_index[place], return_inverse=True)
        yield Part(
            ticket,
            Batch(
                batch.predators[predators],
                batch.prey[prey],
                predator_index.astype(np.uint32),
                prey_index.astype(np.uint32),
            ),
            place,
        )

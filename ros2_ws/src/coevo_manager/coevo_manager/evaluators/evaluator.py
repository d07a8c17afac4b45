"""The evaluator node: plays what others ask of it."""

from __future__ import annotations

import dataclasses
import gc
import os
import socket
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

from coevo_msgs.msg import Environment as EnvironmentMsg
from coevo_msgs.srv import EvaluateBatch, EvaluateLineages
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.service import Service

from coevo_manager.command_line import Parser
from coevo_manager.core.episodes import Environment, EpisodeStream
from coevo_manager.evaluators.messages import (
    to_batch,
    to_environment,
    to_lineages,
    to_sequence,
)
from node_runner import own_arguments, run_ros, stop_requested

WAIT = 0.1
"""Longest wait for a request, s: a signal is honoured within this time."""

DEPTH = 128
"""Requests that may wait unread; the default of services is 10, and what is beyond is lost."""

KEPT_STREAMS = 4
"""Streams kept for environments that nobody asks for at the moment."""


KEPT_ANSWERS = 128
"""Answers remembered for requests that come again."""


@dataclasses.dataclass(slots=True)
class Task:
    """A request that is being played.

    Attributes
    ----------
    service : Service
        Where it was asked.
    number : int
        As the asker counts; 0: not to be recognised.
    request_id
        Of the request, or of its last repetition: there the answer goes.
    """

    service: Service
    number: int
    request_id: Any


class EvaluatorNode(Node):
    """Serves ``evaluate_batch`` and ``evaluate_lineages``, several requests at a time.

    Requests of one environment are merged in one `EpisodeStream`, so that its lanes stay full
    while any of them waits; each is answered as soon as its last episode ends. A request that
    comes again under its number is not played again. An executor would answer one request before
    it takes the next, which is why `serve` turns its own loop.

    Without a namespace given on the command line the node takes one of its own, so that any
    number of evaluators can be started side by side.
    """

    def __init__(self) -> None:
        host = ''.join(c if c.isalnum() and c.isascii() else '_' for c in socket.gethostname())
        super().__init__(
            'evaluator',
            namespace=f'evaluator_{host}_{os.getpid()}',
            start_parameter_services=False,
        )
        self._streams: dict[tuple[Environment, bool], EpisodeStream] = {}
        self._last = EnvironmentMsg(), Environment()
        self._tasks: dict[tuple[Service, int], Task] = {}
        self._answers: dict[tuple[Service, int], Any] = {}
        self._batches = self._serve_type(EvaluateBatch, 'evaluate_batch')
        self._lineages = self._serve_type(EvaluateLineages, 'evaluate_lineages')
        self._wait_set = _rclpy.WaitSet(0, 0, 0, 0, 2, 0, self.context.handle)
        self.get_logger().info(f'ready on {self._batches.service_name}')

    def _serve_type(self, service_type: type, name: str) -> Service:
        return self.create_service(
            service_type, name, self._never_spun, qos_profile=QoSProfile(depth=DEPTH)
        )

    def _never_spun(self, request, response):
        raise RuntimeError('an evaluator is run by serve, not by an executor')

    def serve(self, stop: threading.Event) -> None:
        """Answer requests until `stop` is set."""
        while not stop.is_set():
            self._take_requests(self._batches, self._begin_batch)
            self._take_requests(self._lineages, self._begin_lineages)
            if not self._advance():
                self._wait_set.clear_entities()
                self._wait_set.add_service(self._batches.handle)
                self._wait_set.add_service(self._lineages.handle)
                self._wait_set.wait(int(WAIT * 1e9))

    def _take_requests(self, service: Service, begin: Callable[[Any, Task], None]) -> None:
        while True:
            request, header = service.handle.service_take_request(service.srv_type.Request)
            if request is None:
                return
            task = Task(service, request.number, header.request_id)
            if self._repeated(task):
                continue
            try:
                begin(request, task)
            except ValueError as error:
                self.get_logger().warning(f'refused a request: {error}')
                self._respond(service.srv_type.Response(success=False, message=str(error)), task)

    def _repeated(self, task: Task) -> bool:
        """Look after a request that came before; whether it did."""
        key = task.service, task.number
        if not task.number:
            return False
        if key in self._answers:
            self._send(self._answers[key], task)
        elif key in self._tasks:
            self._tasks[key].request_id = task.request_id
        else:
            self._tasks[key] = task
            return False
        return True

    def _begin_batch(self, request: EvaluateBatch.Request, task: Task) -> None:
        environment = self._environment(request.environment)
        batch = to_batch(request)
        if not len(batch):
            self._respond(EvaluateBatch.Response(success=True), task)
            return
        self._stream(environment, request.complexity).submit(
            task,
            batch.predators,
            batch.prey,
            batch.predator_index,
            batch.prey_index,
            batch.noise,
        )

    def _begin_lineages(self, request: EvaluateLineages.Request, task: Task) -> None:
        environment = self._environment(request.environment)
        self._stream(environment, measured=False).submit_lineages(task, to_lineages(request))

    def _environment(self, message: EnvironmentMsg) -> Environment:
        if message != self._last[0]:
            self._last = message, to_environment(message)
        return self._last[1]

    def _stream(self, environment: Environment, measured: bool) -> EpisodeStream:
        key = environment, measured
        if key not in self._streams:
            idle = [known for known, stream in self._streams.items() if not stream.pending]
            for known in idle[: max(0, len(self._streams) - KEPT_STREAMS)]:
                del self._streams[known]
            self._streams[key] = EpisodeStream(environment, measure=measured)
        return self._streams[key]

    def _advance(self) -> bool:
        busy = [key for key, stream in self._streams.items() if stream.pending]
        for environment, measured in busy:
            for task, ticks, complexity in self._streams[environment, measured].advance():
                response = task.service.srv_type.Response()
                response.success = True
                response.capture_ticks = to_sequence(ticks, 'i')
                if measured:
                    response.predator_complexity = to_sequence(complexity[:, 0], 'f')
                    response.prey_complexity = to_sequence(complexity[:, 1], 'f')
                self._respond(response, task)
        return bool(busy)

    def _respond(self, response: Any, task: Task) -> None:
        response.number = task.number
        if task.number:
            key = task.service, task.number
            del self._tasks[key]
            self._answers[key] = response
            if len(self._answers) > KEPT_ANSWERS:
                del self._answers[next(iter(self._answers))]
        self._send(response, task)

    def _send(self, response: Any, task: Task) -> None:
        try:
            task.service.handle.service_send_response(response, task.request_id)
        except _rclpy.RCLError as error:
            self.get_logger().warning(f'an answer could not be sent: {error}')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the executable ``evaluator``; return its exit code."""
    parser = Parser(
        prog='evaluator',
        description='Plays the episodes of the service evaluate_batch. Runs of evolve find it '
        'and share it; its namespace can be given by --ros-args -r __ns:=/NAME.',
    )
    command_line = list(sys.argv if arguments is None else ['evaluator', *arguments])
    parser.parse_args(own_arguments(command_line))
    return run_ros(_serve, command_line)


def _serve() -> int:
    node = EvaluatorNode()
    gc.freeze()  # what was imported stays: collections need not look at it
    node.serve(stop_requested)
    node.destroy_node()
    return 0


if __name__ == '__main__':
    sys.exit(main())

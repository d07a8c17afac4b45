"""A node of the test itself, that talks with the processes under test."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from node_runner import make_executor, wait_until

TIMEOUT = 40.0
"""How long anything may take, s; the first time, a process compiles its kernels."""


class RosClient:
    """Publishes, listens and calls, always with a time limit.

    Attributes
    ----------
    node, executor
        For whatever else a test needs.
    """

    def __init__(self) -> None:
        self.node = Node('test_client', start_parameter_services=False)
        self.executor = make_executor(self.node)
        self._clients: dict[str, Any] = {}

    def until(self, condition: Callable[[], object], what: str, timeout: float = TIMEOUT) -> None:
        """Spin until a condition holds; AssertionError naming `what` if it does not."""
        try:
            wait_until(self.executor, condition, timeout, what)
        except TimeoutError as error:
            raise AssertionError(str(error)) from None

    def publisher(self, message_type: type, topic: str, qos: QoSProfile | int = 10):
        """Return a publisher that somebody listens to."""
        publisher = self.node.create_publisher(message_type, topic, qos)
        self.until(publisher.get_subscription_count, f'a subscription of {topic}')
        return publisher

    def listen(self, message_type: type, topic: str, qos: QoSProfile | int = 1000) -> list:
        """Return a list that grows with the messages of a topic; somebody publishes it."""
        messages: list = []
        self.node.create_subscription(message_type, topic, messages.append, qos)
        self.until(lambda: self.node.count_publishers(topic), f'a publisher of {topic}')
        return messages

    def call(self, service_type: type, name: str, request: Any = None, **fields: Any) -> Any:
        """Call a service, with a request or the fields of one, and return its response."""
        if name not in self._clients:
            self._clients[name] = self.node.create_client(service_type, name)
            self.until(self._clients[name].service_is_ready, f'the service {name}')
            self._settle()
        client = self._clients[name]
        self.until(client.service_is_ready, f'the service {name}')
        future: Future = client.call_async(request or service_type.Request(**fields))
        self.until(future.done, f'an answer of {name}')
        return future.result()

    def _settle(self) -> None:
        """Spin for a moment in which a server just found discovers this client, too.

        An answer sent before that is lost, and nothing tells when it is safe.
        """
        end = time.monotonic() + 0.3
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)


@contextlib.contextmanager
def ros_client(env: Mapping[str, str]) -> Iterator[RosClient]:
    """Yield a client in the ROS domain of an environment, that also becomes this process's own."""
    before = dict(os.environ)
    os.environ.update(env)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    client = RosClient()
    try:
        yield client
    finally:
        client.executor.shutdown()
        client.node.destroy_node()
        rclpy.try_shutdown()
        os.environ.clear()
        os.environ.update(before)

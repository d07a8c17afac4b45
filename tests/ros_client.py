"""A node of the test itself, that talks with the processes under test."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from node_runner import make_executor, settle, wait_until

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

    def until_ready(self, ready: Callable[[], object], what: str) -> None:
        """Spin until a server is there and knows this client."""
        self.until(ready, what)
        settle(self.executor)

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
            self.until_ready(self._clients[name].service_is_ready, f'the service {name}')
        client = self._clients[name]
        self.until(client.service_is_ready, f'the service {name}')
        future: Future = client.call_async(request or service_type.Request(**fields))
        self.until(future.done, f'an answer of {name}')
        return future.result()


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

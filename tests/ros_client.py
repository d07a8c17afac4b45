"""A node of the test itself, that talks with the processes under test."""

import contextlib
import gc
import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from ros_processes import PATIENCE

from node_runner import ask, make_executor, new_number, wait_until


class RosClient:
    """Publishes, listens and calls, always with a time limit.

    Attributes
    ----------
    node, executor
        For whatever else a test needs.
    goal_clients : list of GoalClient
        To be destroyed with the node.
    """

    def __init__(self) -> None:
        self.node = Node('test_client', start_parameter_services=False)
        self.executor = make_executor(self.node)
        self.goal_clients: list[GoalClient] = []
        self._clients: dict[str, Any] = {}

    def until(self, condition: Callable[[], object], what: str, timeout: float = PATIENCE) -> None:
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
        client = self._clients[name]
        self.until(client.service_is_ready, f'the service {name}')
        wanted = request or service_type.Request(**fields)
        if getattr(wanted, 'number', None) == 0:
            wanted.number = new_number()
        return self.answer(lambda: client.call_async(wanted), f'an answer of {name}')

    def answer(self, send: Callable[[], Future], what: str) -> Any:
        """Send a request until it is answered, and return the answer."""
        try:
            return ask(self.executor, send, PATIENCE, what)
        except TimeoutError as error:
            raise AssertionError(str(error)) from None


class GoalClient(ActionClient):
    """A client of an action whose goals are sent until they are answered.

    Parameters
    ----------
    client : RosClient
    action_type : type
    name : str
    """

    def __init__(self, client: RosClient, action_type: Any, name: str) -> None:
        super().__init__(client.node, action_type, name)
        self._client = client
        client.goal_clients.append(self)
        client.until(self.server_is_ready, f'the action {name}')

    def send(self, goal: Any, on_feedback: Callable | None = None) -> ClientGoalHandle:
        """Send a goal, always under the same id, till it is accepted; return its handle."""
        goal_id = self._generate_random_uuid()
        return self._client.answer(
            lambda: self.send_goal_async(goal, on_feedback, goal_id), 'the acceptance of a goal'
        )

    def result(self, handle: ClientGoalHandle) -> Any:
        """Return the response with the status and the result of a goal."""
        return self._client.answer(handle.get_result_async, 'the result of a goal')

    def cancel(self, handle: ClientGoalHandle) -> Any:
        """Cancel a goal, and return the response."""
        return self._client.answer(handle.cancel_goal_async, 'the cancel of a goal')

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Take what has arrived; a goal that was sent again is accepted again."""
        number, response = taken_data.get('goal', (None, None))
        goal_id = self._goal_sequence_number_to_goal_id.get(number)
        if goal_id is not None and bytes(goal_id.uuid) in self._goal_handles:
            del taken_data['goal']
            self._pending_goal_requests[number].set_result(
                ClientGoalHandle(self, goal_id, response)
            )
        await super().execute(taken_data)


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
        for goal_client in client.goal_clients:
            goal_client.destroy()
        client.executor.shutdown()
        client.node.destroy_node()
        rclpy.try_shutdown()
        gc.collect()  # what still refers to the node keeps its participant alive
        os.environ.clear()
        os.environ.update(before)

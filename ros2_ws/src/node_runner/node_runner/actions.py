"""An action server for long work: one goal at a time, in a thread, safe to be asked twice."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.task import Future

from node_runner.executor import describe


class GoalServer(ActionServer):
    """Works on one goal at a time, in a thread of its own, so that the node hears of a cancel.

    A goal that comes while another is worked on is aborted with one sentence. A goal that is sent
    again under its id is accepted again and not worked on twice: where the first answer was lost
    in discovery, that is all a client has to do.

    Parameters
    ----------
    node : Node
        It is spun meanwhile.
    action_type : type
        Its result has the fields ``success`` and ``message``.
    name : str
    work : callable
        ``work(goal, result)`` fills the result; in the thread. The goal succeeds where the result
        says so; else it was canceled, if that was asked for, or it is aborted. What it raises is
        logged, and told as the message.
    busy : str
        The sentence of goals that are refused meanwhile.
    on_cancel : callable
        Called when a cancel was accepted.
    """

    def __init__(
        self,
        node: Node,
        action_type: Any,
        name: str,
        work: Callable[[ServerGoalHandle, Any], None],
        busy: str,
        on_cancel: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__(
            node, action_type, name, self._work_on, cancel_callback=self._accept_cancel
        )
        self._one_at_a_time = threading.Lock()
        self._work = work
        self._refusal = busy
        self._on_cancel = on_cancel

    @property
    def busy(self) -> bool:
        """Whether a goal is being worked on."""
        return self._one_at_a_time.locked()

    def _accept_cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        del goal
        self._on_cancel()
        return CancelResponse.ACCEPT

    async def _work_on(self, goal: ServerGoalHandle) -> Any:
        result = self._action_type.Result()
        if not self._one_at_a_time.acquire(blocking=False):
            result.message = self._refusal
            goal.abort()
            return result
        done: Future = Future(executor=self._node.executor)

        def work() -> None:
            try:
                self._work(goal, result)
            except Exception as error:
                result.message = describe(error)
                self._node.get_logger().error(f'a goal failed with {result.message}')
            finally:
                done.set_result(None)

        thread = threading.Thread(target=work)
        thread.start()
        await done
        thread.join()
        self._one_at_a_time.release()
        if result.success:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result

    async def _execute_goal_request(self, request_header_and_message: tuple[Any, Any]) -> None:
        header, request = request_header_and_message
        known = self._goal_handles.get(bytes(request.goal_id.uuid))
        if known is None:
            await super()._execute_goal_request(request_header_and_message)
            return
        response = self._action_type.Impl.SendGoalService.Response(
            accepted=True, stamp=known._goal_info.stamp
        )
        with contextlib.suppress(_rclpy.RCLError):  # the client may have gone away
            self._handle.send_goal_response(header, response)

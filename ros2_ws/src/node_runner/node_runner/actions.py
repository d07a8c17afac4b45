"""Goals of an action that are worked on in a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from node_runner.executor import describe


async def work_on(node: Node, goal: ServerGoalHandle, result: Any, work: Callable[[], None]):
    """Do the work of a goal in a thread, so that the node hears of a cancel, and end the goal.

    Parameters
    ----------
    node : Node
        The action server's, which is spun meanwhile.
    goal : ServerGoalHandle
        It succeeds where the result says so; else it was canceled, if that was asked for, or it is
        aborted.
    result : message
        With fields ``success`` and ``message``; `work` fills it.
    work : callable
        What it raises is logged, and told as the message.
    """
    done: Future = Future(executor=node.executor)

    def run() -> None:
        try:
            work()
        except Exception as error:
            result.message = describe(error)
            node.get_logger().error(f'a goal failed with {result.message}')
        finally:
            done.set_result(None)

    thread = threading.Thread(target=run)
    thread.start()
    await done
    thread.join()
    if result.success:
        goal.succeed()
    elif goal.is_cancel_requested:
        goal.canceled()
    else:
        goal.abort()

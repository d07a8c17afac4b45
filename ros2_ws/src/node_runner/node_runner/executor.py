"""The executor of every node: fast, and unharmed by callbacks that raise."""

from __future__ import annotations

import inspect
import traceback
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.executors import Executor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node


class _NodeExecutor(_rclpy.EventsExecutor):
    """The events executor, whose process would end by SIGSEGV when a task of it raises.

    Done callbacks are such tasks. What one raises is raised by `spin_once` instead, as what other
    callbacks raise is.
    """

    def __init__(self, context):
        super().__init__(context)
        self._errors: deque[Exception] = deque()

    def create_task(self, work: Callable, *args: Any, **kwargs: Any) -> Any:
        """Run a function or a coroutine function soon."""
        return super().create_task(self._guarded(work), *args, **kwargs)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for work and do it; raises what a callback of it raised."""
        super().spin_once(timeout_sec)
        if self._errors:
            raise self._errors.popleft()

    def _guarded(self, work: Callable) -> Callable:
        if inspect.iscoroutinefunction(work):

            async def guarded_coroutine(*args, **kwargs):
                try:
                    return await work(*args, **kwargs)
                except Exception as error:
                    self._errors.append(error)

            return guarded_coroutine

        def guarded(*args, **kwargs):
            try:
                return work(*args, **kwargs)
            except Exception as error:
                self._errors.append(error)

        return guarded


def make_executor(node: Node) -> Executor:
    """Return an executor that spins `node`; turn it with ``spin_once`` only."""
    executor = _NodeExecutor(node.context)
    node.context.on_shutdown(executor.wake)
    executor.add_node(node)
    return executor


def describe(error: Exception) -> str:
    """Return in a sentence what was raised, and where."""
    text = ' '.join(str(error).split())
    places = traceback.extract_tb(error.__traceback__)
    where = f' ({places[-1].filename}, line {places[-1].lineno})' if places else ''
    return f'{type(error).__name__}: {text}{where}'

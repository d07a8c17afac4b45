"""Requests that are sent again until they are answered."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import Executor
from rclpy.task import Future

from node_runner.runner import wait_until

FIRST_PAUSE = 0.5
"""How long the first answer is awaited before the request is sent again, s; then twice as long."""


def new_number() -> int:
    """Return a number for a request that no other has, from 1 to 2^64 - 1.

    A server remembers the last numbers that it answered. A request that comes again under one of
    them gets the same answer, and is not worked on twice.
    """
    return secrets.randbits(64) or 1


def ask(executor: Executor, send: Callable[[], Future], timeout: float, what: str) -> Any:
    """Send a request until it is answered, and return the answer.

    The answer of a server that has not discovered its client yet is lost, and no interface tells
    when it has. When this returns, no request is under way any more: a client's requests arrive in
    order, and the last one was answered.

    Parameters
    ----------
    executor : Executor
    send : callable
        Sends the request, the same one each time. What is not harmless to do twice carries a
        number (`new_number`) or an id.
    timeout : float
        Longest wait, s.
    what : str
        What an error says did not happen.

    Raises
    ------
    TimeoutError, KeyboardInterrupt
        See `node_runner.wait_until`.
    """
    last, again, pause = send(), time.monotonic() + FIRST_PAUSE, FIRST_PAUSE

    def answered() -> bool:
        nonlocal last, again, pause
        if not last.done() and time.monotonic() > again:
            pause *= 2
            last, again = send(), time.monotonic() + pause
        return last.done()

    wait_until(executor, answered, timeout, what)
    return last.result()

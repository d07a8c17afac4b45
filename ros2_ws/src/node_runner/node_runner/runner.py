"""The loop of every node, and waiting with a time limit while it turns."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor
from rclpy.node import Node

from node_runner.complaints import Complaints
from node_runner.executor import describe, make_executor
from node_runner.interface import Interface
from node_runner.services import answer_always
from node_runner.start import complain, own_arguments, start_ros

SPIN_TIMEOUT = 0.1
"""Longest wait of one turn of the loop, s: a signal is honoured within this time."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

stop_requested = threading.Event()
"""Set by the first SIGINT, SIGTERM or SIGHUP of a process that called `run_ros`."""


@runtime_checkable
class Worker(Protocol):
    """A node that works in threads of its own, beside what its callbacks do."""

    @property
    def busy(self) -> bool:
        """Whether there is work under way."""
        ...

    def stop(self) -> None:
        """Ask the work under way to end soon."""
        ...


@runtime_checkable
class Careful(Protocol):
    """A node that makes itself safe when one of its callbacks raised."""

    def on_failure(self, reason: str) -> None:
        """Command a stop, say; `reason` tells what was raised, and where."""
        ...


def run_ros(work: Callable[[], int], args: Sequence[str] | None = None) -> int:
    """Do something with ROS 2 until it is done or a signal comes; leave nothing behind.

    Parameters
    ----------
    work
        Returns an exit code. It waits by `wait_until`, which raises `KeyboardInterrupt` when a
        signal came. `ValueError` is bad input, `RuntimeError` and `OSError` are failures: their
        text is printed on stderr.
    args
        Command line, with the name of the program and the ``--ros-args``; None takes ``sys.argv``.

    Returns
    -------
    int
        Exit code: 0 after a signal, 2 after bad input, 1 after a failure, else that of `work`.
    """
    command_line = sys.argv if args is None else args
    start_ros(command_line)
    for number in _SIGNALS:
        signal.signal(number, lambda *_: stop_requested.set())
    try:
        return work()
    except KeyboardInterrupt:
        return 0
    except (ValueError, ParameterException) as error:
        complain(command_line, error)
        return 2
    except (RuntimeError, OSError) as error:
        complain(command_line, error)
        return 1
    finally:
        rclpy.try_shutdown()


def run_node(make_node: Callable[[], Node], interface: Interface) -> int:
    """Spin a node until a signal comes, see `run_ros`; a `Worker` then ends its work first.

    What a callback raises while the node spins is logged, and the node lives on; a `Careful` one
    makes itself safe first. With ``--help``, its interface is printed instead.
    """
    match own_arguments(sys.argv):
        case ['--help' | '-h']:
            print(interface.help())
            return 0
        case [first, *_]:
            print(
                f'{interface.command}: the argument {first!r} is not known; it takes --help and '
                'what follows --ros-args',
                file=sys.stderr,
            )
            return 2

    def spin() -> int:
        node = _interruptible(make_node)
        complaints = Complaints(node.get_logger())

        def fail(error: Exception) -> None:
            reason = describe(error)
            complaints.error(f'a callback failed with {reason}')
            if isinstance(node, Careful):
                try:
                    node.on_failure(reason)
                except Exception as another:
                    complaints.error(f'making safe failed with {describe(another)}')

        def turn() -> None:
            try:
                executor.spin_once(timeout_sec=SPIN_TIMEOUT)
            except Exception as error:
                fail(error)

        answer_always(node, fail)
        executor = make_executor(node)
        try:
            while not stop_requested.is_set():
                turn()
            if isinstance(node, Worker):
                node.stop()
                while node.busy:
                    turn()
        finally:
            executor.shutdown()
            node.destroy_node()
        return 0

    return run_ros(spin)


def _interruptible(make_node: Callable[[], Node]) -> Node:
    """Make a node; a signal meanwhile, when kernels may be compiled, ends that at once."""

    def interrupt(*_) -> None:
        stop_requested.set()
        raise KeyboardInterrupt

    handlers = {number: signal.signal(number, interrupt) for number in _SIGNALS}
    try:
        return make_node()
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)


def wait_until(executor: Executor, condition: Callable[[], bool], timeout: float, what: str):
    """Spin until `condition` holds.

    Raises
    ------
    TimeoutError
        `what` did not happen within `timeout` seconds.
    RuntimeError
        A callback raised something else.
    KeyboardInterrupt
        A signal asked the process to end.
    """
    deadline = time.monotonic() + timeout
    while not condition():
        if stop_requested.is_set():
            raise KeyboardInterrupt
        remaining = deadline - time.monotonic()
        if remaining <= 0:
            raise TimeoutError(f'{what} did not happen within {timeout:g} s')
        _turn(executor, min(remaining, SPIN_TIMEOUT))


def _turn(executor: Executor, timeout: float) -> None:
    try:
        executor.spin_once(timeout_sec=timeout)
    except (RuntimeError, TimeoutError):
        raise
    except Exception as error:
        raise RuntimeError(f'a callback failed with {describe(error)}') from error

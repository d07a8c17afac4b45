"""The command line of an executable, and the start of rclpy."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args


def own_arguments(command_line: Sequence[str]) -> list[str]:
    """Return the arguments that are not for ROS; bad ROS arguments exit with code 2."""
    with _refusing(command_line[0]):
        return remove_ros_args(command_line)[1:]


def start_ros(command_line: Sequence[str]) -> None:
    """Initialise rclpy, leaving the signals alone; bad ROS arguments exit with code 2."""
    with _refusing(command_line[0]):
        rclpy.init(args=command_line, signal_handler_options=SignalHandlerOptions.NO)


@contextlib.contextmanager
def _refusing(program: str) -> Iterator[None]:
    try:
        yield
    except (_rclpy.RCLError, _rclpy.UnknownROSArgsError) as error:
        sentence = ' '.join(str(error).split(', at ')[0].split())
        print(f'{Path(program).stem}: {sentence}', file=sys.stderr)
        sys.exit(2)

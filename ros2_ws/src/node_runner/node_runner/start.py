"""The command line of an executable, and the start of rclpy."""

from __future__ import annotations

import contextlib
import itertools
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import LoggingSeverity, get_logger_level, set_logger_level
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

DEEPEST = 100
"""Brackets within brackets of a parameter file; rcl takes minutes for some ten thousand."""


def own_arguments(command_line: Sequence[str]) -> list[str]:
    """Return the arguments that are not for ROS; bad ROS arguments exit with code 2."""
    with _refusing(command_line):
        return remove_ros_args(command_line)[1:]


def start_ros(command_line: Sequence[str]) -> None:
    """Initialise rclpy, leaving the signals alone; bad ROS arguments exit with code 2."""
    with _refusing(command_line):
        rclpy.init(args=list(command_line), signal_handler_options=SignalHandlerOptions.NO)


def parameter_files(command_line: Sequence[str]) -> Iterator[Path]:
    """Yield what a command line gives as ``--params-file``."""
    for option, file in itertools.pairwise(command_line):
        if option == '--params-file':
            yield Path(file)


def _check(file: Path) -> None:
    """Refuse by a ValueError a parameter file on which rcl would hang."""
    if not file.is_file():
        raise ValueError(f'parameter file {file} is no file, expected one of YAML')
    depth = 0
    for bracket in re.finditer(rb'[][{}]', file.read_bytes()):
        depth += 1 if bracket.group() in b'[{' else -1
        if depth > DEEPEST:
            raise ValueError(f'parameter file {file} has more than {DEEPEST} brackets in brackets')


def complain(command_line: Sequence[str], error: object) -> None:
    """Print on stderr what went wrong, after the name of the program."""
    print(f'{Path(command_line[0]).stem}: {error}', file=sys.stderr)


@contextlib.contextmanager
def _refusing(command_line: Sequence[str]) -> Iterator[None]:
    set_logger_level('rcl', LoggingSeverity.FATAL)  # it would say the same in lines of its own
    try:
        for file in parameter_files(command_line):
            _check(file)
        yield
    except (ValueError, OSError, _rclpy.RCLError, _rclpy.UnknownROSArgsError) as error:
        complain(command_line, ' '.join(str(error).split(', at ')[0].split()))
        sys.exit(2)
    finally:
        if get_logger_level('rcl') == LoggingSeverity.FATAL:
            set_logger_level('rcl', LoggingSeverity.UNSET)

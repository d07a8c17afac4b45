"""The command line of an executable, and the start of rclpy."""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
import pwd
import re
import reprlib
import socket
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import rclpy
from ament_index_python.packages import get_package_share_directory
from rclpy.exceptions import NameValidationException
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import LoggingSeverity, get_logger_level, set_logger_level
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name

DEEPEST = 100
"""Brackets within brackets of a parameter file; rcl takes minutes for some ten thousand."""

_RENAMING = re.compile(r'(?:[^:]+:)?__(?:ns:=/?(?P<namespace>.*)|(?:node|name):=(?P<node>.*))')

_SWITCH = (re.compile('|0|1'), '0 or 1')
_VARIABLES = {
    'ROS_DOMAIN_ID': (
        re.compile(r'|\d{1,2}|1\d\d|2[0-2]\d|23[0-2]', re.ASCII),
        'a whole number from 0 to 232',
    ),
    'ROS_AUTOMATIC_DISCOVERY_RANGE': (
        re.compile('|SUBNET|LOCALHOST|OFF|SYSTEM_DEFAULT'),
        'SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT',
    ),
    'RCUTILS_COLORIZED_OUTPUT': _SWITCH,
    'RCUTILS_LOGGING_BUFFERED_STREAM': _SWITCH,
    'RCUTILS_LOGGING_USE_STDOUT': _SWITCH,
}
"""What ROS reads in the environment and refuses in several lines or not at all."""


def own_arguments(command_line: Sequence[str]) -> list[str]:
    """Return the arguments that are not for ROS; bad ROS arguments exit with code 2."""
    with _refusing(command_line):
        return remove_ros_args(command_line)[1:]


def start_ros(command_line: Sequence[str]) -> None:
    """Initialise rclpy, leaving the signals alone; bad ROS arguments exit with code 2.

    Fast DDS prints its errors on stderr, unless the user gave it profiles of their own.
    """
    with _refusing(command_line):
        if not any(os.environ.get(name) for name in ('HOME', 'ROS_HOME', 'ROS_LOG_DIR')):
            # rcl's logs need a home, and it looks nowhere else
            with contextlib.suppress(KeyError):
                os.environ['HOME'] = pwd.getpwuid(os.getuid()).pw_dir
        share = Path(get_package_share_directory('node_runner'))
        os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(share / 'fastdds.xml'))
        rclpy.init(args=list(command_line), signal_handler_options=SignalHandlerOptions.NO)


def parameter_files(command_line: Sequence[str]) -> Iterator[Path]:
    """Yield what a command line gives as ``--params-file``."""
    for option, file in itertools.pairwise(command_line):
        if option == '--params-file':
            yield Path(file)


def _check_names(command_line: Sequence[str]) -> None:
    """Refuse by a ValueError a name for nodes or a namespace, of which no node could be made."""
    for option, rule in itertools.pairwise(command_line):
        renaming = _RENAMING.fullmatch(rule)
        if option not in ('-r', '--remap') or not renaming:
            continue
        try:
            if renaming['node'] is None:
                validate_namespace(f'/{renaming["namespace"]}')
            else:
                validate_node_name(renaming['node'])
        except NameValidationException as error:
            reason = str(error).partition(':\n')[0]
            raise ValueError(f'{option} is {reprlib.repr(rule)}: {reason}') from None


def _check(file: Path) -> None:
    """Refuse by a ValueError a parameter file on which rcl would hang."""
    if not file.is_file():
        raise ValueError(f'parameter file {file} is no file, expected one of YAML')
    depth = 0
    for bracket in re.finditer(rb'[][{}]', file.read_bytes()):
        depth += 1 if bracket.group() in b'[{' else -1
        if depth > DEEPEST:
            raise ValueError(f'parameter file {file} has more than {DEEPEST} brackets in brackets')


def _check_variables() -> None:
    """Refuse by a ValueError an environment variable with which rclpy would not start."""
    for name, (pattern, expected) in _VARIABLES.items():
        value = os.environ.get(name, '')
        if not pattern.fullmatch(value):
            raise ValueError(f'{name} is {value[:40]!r}, expected {expected}')


def _check_peers() -> None:
    """Refuse by a ValueError peers that have no address, on which no node would start."""
    for peer in filter(None, os.environ.get('ROS_STATIC_PEERS', '').split(';')):
        if not _has_address(peer):
            raise ValueError(
                f'ROS_STATIC_PEERS names {peer[:40]!r}, which has no address, expected hosts or '
                'addresses with ; between them'
            )


@functools.cache
def _has_address(host: str) -> bool:
    try:
        socket.getaddrinfo(host, None)
    except (OSError, UnicodeError):
        return False
    return True


def complain(command_line: Sequence[str], error: object) -> None:
    """Print on stderr in one line what went wrong, after the name of the program."""
    said = re.sub(r'\s*, at \S+:\d+', '', str(error))  # rcl adds places in its sources
    print(f'{Path(command_line[0]).stem}: {" ".join(said.split())}', file=sys.stderr)


@contextlib.contextmanager
def _refusing(command_line: Sequence[str]) -> Iterator[None]:
    try:
        _check_variables()
        _check_peers()
        _check_names(command_line)
        with _rcl_silent():
            for file in parameter_files(command_line):
                _check(file)
            yield
    except (ValueError, OSError, _rclpy.RCLError, _rclpy.UnknownROSArgsError) as error:
        complain(command_line, error)
        sys.exit(2)


@contextlib.contextmanager
def _rcl_silent() -> Iterator[None]:
    """Keep rcl from logging what it raises, in lines of its own."""
    set_logger_level('rcl', LoggingSeverity.FATAL)
    try:
        yield
    finally:
        if get_logger_level('rcl') == LoggingSeverity.FATAL:
            set_logger_level('rcl', LoggingSeverity.UNSET)

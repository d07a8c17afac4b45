"""`coevo_manager dashboard`: a page that shows runs while they run and after."""

from __future__ import annotations

import argparse
import ipaddress
import os
import secrets
import signal
import socket
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from coevo_manager.command_line import Parser, add_option, any_path, carry_out
from coevo_manager.outlet import Outlet
from marxbot_sim.core.fields import Option

if TYPE_CHECKING:
    from coevo_manager.dashboard.server import Robots

PORT = Option('port', int, 0, 'port to answer on; 0: any that is free', minimum=0, maximum=65535)

NICENESS = 5
"""A run beside the dashboard goes first."""


def make_parser() -> Parser:
    """Make the command line."""
    parser = Parser(
        prog='dashboard',
        description='Serve a page on this machine that shows runs while they run and after: how '
        'far they are, their evaluators, their curves, and chases between their champions.',
    )
    parser.add_argument(
        'runs',
        nargs='*',
        metavar='RUNS',
        type=_folder,
        help='run folders, or folders with runs under them (default: runs)',
    )
    add_option(parser, PORT)
    parser.add_argument(
        '--host',
        type=_address,
        default='127.0.0.1',
        metavar='ADDRESS',
        help='address of this machine to answer on; with any but its loopback the page asks for '
        'a token, which is printed (default: %(default)s)',
    )
    parser.add_argument(
        '--topics',
        action='store_true',
        help='also show the robots that run now, from their ROS topics, and offer their services',
    )
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Serve until SIGINT or SIGTERM; returns 0, or 2 for bad input."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _end)
    command_line = list(sys.argv if argv is None else ['dashboard', *argv])
    if '--topics' in command_line:
        from node_runner import own_arguments

        options = make_parser().parse_args(own_arguments(command_line))
    else:
        options = make_parser().parse_args(command_line[1:])
    return carry_out('dashboard', lambda: _serve(options, command_line), (ValueError, OSError))


def _end(*_: object) -> NoReturn:
    sys.exit(0)


def _serve(options: argparse.Namespace, command_line: Sequence[str]) -> int:
    folders = options.runs or [_default_folder()]
    loopback = ipaddress.ip_address(options.host).is_loopback
    family = socket.AF_INET6 if ':' in options.host else socket.AF_INET
    with socket.create_server((options.host, options.port), family=family) as place:
        port = place.getsockname()[1]
        shown = f'[{options.host}]' if family == socket.AF_INET6 else options.host
        token = '' if loopback else secrets.token_urlsafe(24)
        names = frozenset(f'{name}:{port}' for name in (shown, 'localhost')) if loopback else None
        with _robots(options.topics, command_line) as robots:
            import uvicorn

            from coevo_manager.dashboard.library import Library
            from coevo_manager.dashboard.server import make_app

            app = make_app(Library(folders), robots, names, token, lambda: server.should_exit)
            server = uvicorn.Server(
                uvicorn.Config(app, log_level='warning', ws='none', lifespan='off')
            )
            query = f'?token={token}' if token else ''
            print(f'http://{shown}:{port}/{query}', file=Outlet(), flush=True)
            os.nice(NICENESS)
            server.run(sockets=[place])
    return 0


@contextmanager
def _robots(wanted: bool, command_line: Sequence[str]) -> Iterator[Robots | None]:
    if not wanted:
        yield None
        return
    import rclpy

    from coevo_manager.dashboard.topics import RosRobots
    from node_runner import start_ros

    start_ros(command_line)
    robots = RosRobots()
    try:
        yield robots
    finally:
        robots.close()
        rclpy.try_shutdown()


def _default_folder() -> Path:
    try:
        return _folder('runs')
    except argparse.ArgumentTypeError as error:
        raise ValueError(f'{error}; name another') from None


def _folder(text: str) -> Path:
    path = any_path(text)
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f'{text} is no folder, expected one with runs')
    return path


def _address(text: str) -> str:
    try:
        return str(ipaddress.ip_address({'localhost': '127.0.0.1'}.get(text, text)))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'host is {text!r}, expected an address of this machine, such as 127.0.0.1'
        ) from None


if __name__ == '__main__':
    sys.exit(main())

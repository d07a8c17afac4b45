"""The part of the command ``ros2`` that this workspace needs, where no ROS 2 is installed."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

from ament_index_python import (
    PackageNotFoundError,
    get_package_prefix,
    get_packages_with_prefixes,
    get_resources,
)
from ros2_bag import bag


def executables(package: str) -> dict[str, Path]:
    """Return the executables of a package: name -> path, by name.

    Raises
    ------
    ValueError
        The package is not in the ament index.
    """
    folder = _prefix(package) / 'lib' / package
    if not folder.is_dir():
        return {}
    return {
        path.name: path
        for path in sorted(folder.iterdir())
        if path.is_file() and os.access(path, os.X_OK)
    }


def _prefix(package: str) -> Path:
    try:
        return Path(get_package_prefix(package))
    except (PackageNotFoundError, ValueError):
        raise ValueError(
            f'package {package!r} was not found (scripts/ros2 pkg list names those there are)'
        ) from None


def run(arguments: list[str]) -> int:
    """Become the executable that the arguments name."""
    if len(arguments) < 2:
        raise ValueError('run needs a package and an executable')
    package, name, *rest = arguments
    found = executables(package)
    if name not in found:
        raise ValueError(
            f'package {package!r} has no executable {name!r}; it has '
            f'{", ".join(found) or "none at all"}'
        )
    os.execv(found[name], [str(found[name]), *rest])


def pkg(arguments: list[str]) -> int:
    """List packages, or executables as ``PACKAGE EXECUTABLE``."""
    match arguments:
        case ['list']:
            print(*sorted(get_packages_with_prefixes()), sep='\n')
        case ['executables']:
            for package in sorted(get_packages_with_prefixes()):
                _print_executables(package)
        case ['executables', package]:
            _print_executables(package)
        case ['prefix', package]:
            print(_prefix(package))
        case ['prefix', '--share', package]:
            print(_prefix(package) / 'share' / package)
        case _:
            raise ValueError(
                f'argument of pkg is {" ".join(arguments)!r}, expected list, '
                'executables [PACKAGE] or prefix [--share] PACKAGE'
            )
    return 0


def _print_executables(package: str) -> None:
    for name in executables(package):
        print(package, name)


def launch(arguments: list[str]) -> int:
    """Start what a launch file names."""
    import ros2_launch  # here, since a middleware that is not installed lets rclpy end the process

    return ros2_launch.launch(arguments)


def graph(command: str) -> Callable[[list[str]], int]:
    """Return a command that asks running nodes."""

    def ask(arguments: list[str]) -> int:
        import ros2_graph  # here, as above

        return ros2_graph.carry_out(command, arguments)

    return ask


def version(arguments: list[str]) -> int:
    """Print which version of the project this is, and of which commit."""
    from coevo_manager import __version__  # here, as above
    from coevo_manager.core.evolution.commit import source_commit

    print(f'Red Queen {__version__}, commit {source_commit() or "unknown"}')
    return 0


COMMANDS = {'--version': version, 'run': run, 'launch': launch, 'pkg': pkg, 'bag': bag} | {
    command: graph(command) for command in ('node', 'topic', 'service', 'param', 'lifecycle')
}


def check_middleware() -> None:
    """Raise ValueError if the middleware that the environment names is not installed."""
    name = os.environ.get('RMW_IMPLEMENTATION')
    known = sorted({*get_resources('rmw_typesupport')} - {'rmw_implementation'})
    if name and name not in known:
        raise ValueError(
            f'RMW_IMPLEMENTATION is {name!r}, which is not installed; there is {", ".join(known)}'
        )


def main(arguments: list[str]) -> int:
    """Carry out one command; bad input is one sentence on stderr and exit code 2."""
    command, *rest = arguments
    try:
        if command not in COMMANDS:
            raise ValueError(f'command is {command!r}, expected one of {", ".join(COMMANDS)}')
        check_middleware()
        return COMMANDS[command](rest)
    except ValueError as error:
        print(f'ros2: {error}', file=sys.stderr)
        return 2


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))

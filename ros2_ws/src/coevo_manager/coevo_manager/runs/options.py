"""The command line of evolve, made from the fields of the configuration."""

from __future__ import annotations

import argparse
import dataclasses
import sys
import types
import typing
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import yaml

from coevo_manager.core.configuration import FIELDS, PRESETS, Configuration
from coevo_manager.core.evolution import algorithms, optimizers, registry
from coevo_manager.core.worlds import WORLDS

_TYPES = typing.get_type_hints(Configuration)


@dataclasses.dataclass(frozen=True)
class Options:
    """What the command line says.

    Attributes
    ----------
    values : dict
        Fields of `Configuration` that were given, in the file or as options.
    preset : str
    out, resume : Path or None
    evaluators : int or None
        Evaluator processes to start; 0: use running ones; None: one for each core.
    patience : float
        The shortest time after which an evaluator counts as late, s.
    """

    values: dict[str, Any]
    preset: str
    out: Path | None
    resume: Path | None
    evaluators: int | None
    patience: float


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Print the sentence and exit with code 2."""
        print(f'{self.prog}: {message}', file=sys.stderr)
        sys.exit(2)


def read_options(arguments: Sequence[str]) -> Options:
    """Read the command line, without its ROS arguments; bad input exits with code 2.

    Raises
    ------
    ValueError
        Options that exclude each other, or a configuration file that cannot be read.
    """
    given = vars(_make_parser().parse_args(arguments))
    values = _read_file(given['config']) if given['config'] else {}
    values |= {name: given[name] for name in FIELDS if name in given}
    if given['resume'] is not None:
        for name in ('preset', 'config', 'out'):
            if given[name] is not None:
                raise ValueError(f'--{name} cannot be given with --resume: a run keeps its own')
    return Options(
        values,
        given['preset'] or 'quick',
        given['out'],
        given['resume'],
        given['evaluators'],
        given['patience'],
    )


def _make_parser() -> Parser:
    parser = Parser(
        prog='evolve',
        description='Co-evolves predators and prey, playing the episodes on evaluator nodes in '
        'processes of their own, and writes a run folder. Ctrl-C ends it; --resume goes on.',
        epilog='Results depend on the configuration alone, not on the evaluators.',
        allow_abbrev=False,
    )
    run = parser.add_argument_group('run')
    run.add_argument(
        '--preset',
        choices=PRESETS,
        help='numbers to start from: quick takes about a minute on two cores, paper is one '
        'replication of Simione and Nolfi (2019) (default: quick)',
    )
    run.add_argument(
        '--config', type=Path, metavar='FILE', help='YAML or JSON file with any of the '
        'configuration below, by name with underscores; options go before it',
    )  # fmt: skip
    run.add_argument(
        '--out', type=Path, metavar='DIR', help='run folder, new or empty '
        '(default: runs/<algorithm>-<seed>-<number>, the first that is free)',
    )  # fmt: skip
    run.add_argument(
        '--resume', type=Path, metavar='DIR', help='go on with the run in this folder, to the '
        'same files as if it had never stopped',
    )  # fmt: skip
    run.add_argument(
        '--evaluators', type=_number(int, 0, 1024), nargs='?', const=0, metavar='NUMBER',
        help='evaluator processes to start (default: one for each core); without a number, or 0: '
        'start none and use those already running. Evaluators that join later are used too',
    )  # fmt: skip
    run.add_argument(
        '--patience', type=_number(float, 0.1, 86400), default=5.0, metavar='NUMBER',
        help='an evaluator silent for so long, and ten times longer than expected, counts as '
        'late: its work goes to another (s; default: %(default)g)',
    )  # fmt: skip
    group = parser.add_argument_group('configuration')
    for name, field in FIELDS.items():
        choices = {'algorithm': algorithms, 'optimizer': optimizers}.get(name)
        names = registry.names(choices) if choices else field.metadata['choices']
        group.add_argument(
            f'--{name.replace("_", "-")}',
            type=_reader(name),
            choices=names or None,
            default=argparse.SUPPRESS,
            metavar=None if names else _kind(name).__name__.upper(),
            help=_help(name, field),
        )
    return parser


def _help(name: str, field: dataclasses.Field) -> str:
    facts = [field.metadata['unit']] if field.metadata['unit'] else []
    if field.default is not None:
        facts.append(f'default: {field.default}')
    facts += [
        f'{key}: {values[name]}'
        for key, values in {**PRESETS, **WORLDS}.items()
        if values.get(name, field.default) != field.default
    ]
    text = field.metadata['help'] + (f' ({"; ".join(facts)})' if facts else '')
    return text.replace('%', '%%')


def _kind(name: str) -> type:
    """Return the type of a field that is not None."""
    kind = _TYPES[name]
    return typing.get_args(kind)[0] if isinstance(kind, types.UnionType) else kind


def _reader(name: str) -> Callable[[str], Any]:
    kind, optional = _kind(name), isinstance(_TYPES[name], types.UnionType)
    expected = {int: 'a whole number', float: 'a number', str: 'text'}[kind]

    def read(text: str) -> Any:
        if optional and text == 'none':
            return None
        try:
            return kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'expected {expected}, got {text!r}') from None

    return read


def _number(kind: type, low: float, high: float) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            if low <= (value := kind(text)) <= high:
                return value
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(
            f'expected a {"whole " if kind is int else ""}number from {low} to {high}, '
            f'got {text!r}'
        )

    return read


def _read_file(path: Path) -> dict[str, Any]:
    try:
        content = yaml.safe_load(path.read_text())
    except OSError as error:
        raise ValueError(f'cannot read {path}: {error.strerror}') from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = ' '.join(str(error).split())
        raise ValueError(f'{path} is neither YAML nor JSON: {reason}') from None
    if not isinstance(content, dict):
        raise ValueError(f'{path} must hold a mapping of configuration keys to values')
    return content

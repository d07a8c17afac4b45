"""The command line of evolve, made from the fields of the configuration."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from coevo_manager.command_line import Parser, add_option, any_path
from coevo_manager.core.configuration import PRESETS
from coevo_manager.core.documents import read_document
from coevo_manager.core.evolution import read_record
from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.core.worlds import WORLDS
from marxbot_sim.core.fields import Option

EVALUATORS = Option(
    'evaluators',
    int,
    None,
    'evaluator processes to start (default: one for each core); without a number, or 0: start '
    'none and use those already running. Evaluators that join later are used too',
    minimum=0,
    maximum=1024,
)
PATIENCE = Option(
    'patience',
    float,
    5.0,
    'an evaluator silent for so long, and ten times longer than expected, counts as late: its '
    'work goes to another',
    's',
    minimum=0.1,
    maximum=86400.0,
)

_WORLD_SETTINGS = {name for settings in WORLDS.values() for name in settings}


@dataclasses.dataclass(frozen=True)
class Options:
    """What the command line says.

    Attributes
    ----------
    values : dict
        Fields of `Configuration` that were given, in the file or as options.
    preset : str
    print_config : bool
        Whether to print the configuration instead of running it.
    quiet : bool
        Whether to show nothing but errors, and the address of the page.
    dashboard : bool
        Whether to start a page that shows the run.
    out, resume : Path or None
    evaluators : int or None
        Evaluator processes to start; 0: use running ones; None: one for each core.
    patience : float
        The shortest time after which an evaluator counts as late, s.
    """

    values: dict[str, Any]
    preset: str
    print_config: bool
    quiet: bool
    dashboard: bool
    out: Path | None
    resume: Path | None
    evaluators: int | None
    patience: float


def read_options(arguments: Sequence[str]) -> Options:
    """Read the command line, without its ROS arguments; bad input exits with code 2.

    Raises
    ------
    ValueError
        Options that exclude each other, or a configuration file that cannot be read.
    """
    given = vars(_make_parser().parse_args(arguments))
    values = _read_file(given['config']) if given['config'] else {}
    if 'world' in given:
        values = {name: values[name] for name in values.keys() - _WORLD_SETTINGS}
    values |= {name: given[name] for name in all_fields() if name in given}
    if given['resume'] is not None:
        for name in ('preset', 'config', 'out', 'print_config'):
            if given[name]:
                raise ValueError(
                    f'{name} is given, expected none with --resume: a run keeps its own'
                )
    return Options(
        values,
        given['preset'] or 'quick',
        given['print_config'],
        given['quiet'],
        given['dashboard'],
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
    )
    run = parser.add_argument_group('run')
    run.add_argument(
        '--preset',
        choices=PRESETS,
        help='numbers to start from: quick takes about a minute on two cores, paper is one '
        'replication of Simione and Nolfi (2019) (default: quick)',
    )
    run.add_argument(
        '--config', type=any_path, metavar='FILE', help='YAML or JSON file with any of the '
        'configuration below, by name with underscores, or the run.json of a run to repeat; '
        'options go before it, and --world before its settings in the file',
    )  # fmt: skip
    run.add_argument(
        '--print-config', action='store_true', help='print such a file, commented, with what the '
        'options and the preset say, instead of running',
    )  # fmt: skip
    run.add_argument(
        '--out', type=any_path, metavar='DIR', help='run folder, new or empty '
        '(default: runs/<algorithm>-<seed>-<number>, the first that is free)',
    )  # fmt: skip
    run.add_argument(
        '--resume', type=any_path, metavar='DIR', help='go on with the run in this folder, to the '
        'same files as if it had never stopped',
    )  # fmt: skip
    run.add_argument(
        '--quiet',
        action='store_true',
        help='show nothing but errors and the address of --dashboard',
    )
    run.add_argument(
        '--dashboard', action='store_true', help='serve a page on this machine that shows the run '
        'while it goes on, and print its address',
    )  # fmt: skip
    add_option(run, EVALUATORS, nargs='?', const=0)
    add_option(run, PATIENCE)
    group = parser.add_argument_group('configuration')
    presets = {**PRESETS, **WORLDS}
    for option in all_fields().values():
        add_option(group, option, presets, default=argparse.SUPPRESS)
    return parser


def _read_file(path: Path) -> dict[str, Any]:
    content = read_document(path)
    if isinstance(content, dict) and 'configuration' in content:
        return read_record(path)[0].as_dict()
    if not isinstance(content, dict):
        raise ValueError(f'{path} is no mapping, expected keys of the configuration with values')
    return content

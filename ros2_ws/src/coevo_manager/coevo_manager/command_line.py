"""The command line of every command: options, refusals of bad input, exit codes."""

from __future__ import annotations

import argparse
import contextlib
import errno
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from coevo_manager import __version__
from coevo_manager.core.environment import OPTIONS, REPLACEABLE, Environment
from coevo_manager.core.provenance import choose_environment
from coevo_manager.core.species import SPECIES
from coevo_manager.core.worlds import WORLD
from marxbot_sim.core.fields import Option
from neuro_controller.core.champions import Champion, select_champion

GENOME_HELP = (
    'RUN[:GENERATION[:RANK]], a run folder or snapshot, the generation (default: last) and the '
    'rank in it (default: 0, the champion); or shipped/open or shipped/obstacle'
)

_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


_TRUTHS = {'true': True, 'false': False}


class Parser(argparse.ArgumentParser):
    """A parser whose options have one name each and whose errors are one sentence."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, allow_abbrev=False)
        self.add_argument(
            '--version',
            action='version',
            version=f'%(prog)s of Red Queen {__version__}',
            help='print the version and exit',
        )

    def error(self, message: str) -> NoReturn:
        """Print the sentence and exit with code 2; an option is named once."""
        sentence = re.sub(r'^argument [^:]+: (?=\w+ is )', '', message)
        print(f'{self.prog}: {sentence}', file=sys.stderr)
        sys.exit(2)


def refuse(program: str, error: Exception) -> int:
    """Print why a command cannot do what was asked; return its exit code.

    Returns
    -------
    int
        2 for bad input, 1 where a file cannot be written whole, as on a full disk.
    """
    if isinstance(error, OSError) and error.strerror:
        print(f'{program}: {error.filename or "a file"}: {error.strerror}', file=sys.stderr)
        return 1 if error.errno in _NO_ROOM else 2
    print(f'{program}: {error}', file=sys.stderr)
    return 2


def carry_out(
    program: str,
    work: Callable[[], int],
    refused: type[Exception] | tuple[type[Exception], ...],
    interrupted: str = 'interrupted',
) -> int:
    """Do what a command is for.

    Parameters
    ----------
    program : str
    work : callable
        Returns an exit code.
    refused : exceptions
        What `work` raises for bad input; their text is one sentence.
    interrupted : str
        What to say after Ctrl-C.

    Returns
    -------
    int
        That of `work`, 2 after bad input, 1 on a full disk, 130 after Ctrl-C.
    """
    try:
        return work()
    except refused as error:
        return refuse(program, error)
    except KeyboardInterrupt:
        print(f'{program}: {interrupted}', file=sys.stderr)
        return 130


def add_option(
    group: argparse._ActionsContainer,
    option: Option,
    presets: Mapping[str, Mapping[str, Any]] = {},
    **settings: Any,
) -> None:
    """Add an option as ``--its-name``; its type, default, limits and help follow from it.

    Parameters
    ----------
    group
        A parser, or a group of one.
    option : Option
    presets : mapping
        Other defaults by the names of the presets they belong to, for the help.
    settings
        Of argparse's ``add_argument``, to go before those that follow from the option.
    """
    facts = [option.unit] if option.unit else []
    if option.default is not None:
        facts.append(f'default: {option.default}')
    facts += [
        f'{name}: {values[option.name]}'
        for name, values in presets.items()
        if values.get(option.name, option.default) != option.default
    ]
    text = option.help + (f' ({"; ".join(facts)})' if facts else '')
    kinds = {int: 'NUMBER', float: 'NUMBER', str: 'TEXT', bool: '{true,false}'}
    group.add_argument(
        f'--{option.name.replace("_", "-")}',
        **{
            'type': reader(option),
            'default': option.default,
            'metavar': f'{{{",".join(option.choices)}}}' if option.choices else kinds[option.kind],
            'help': text.replace('%', '%%'),
            **settings,
        },
    )


def reader(option: Option) -> Callable[[str], Any]:
    """Return what reads the value of an option from text; an argparse type."""

    def read(text: str) -> Any:
        if option.optional and text == 'none':
            return None
        value: Any = text
        with contextlib.suppress(ValueError, KeyError):  # the check says what is wrong
            value = _TRUTHS[text] if option.kind is bool else option.kind(text)
        try:
            return option.check(value)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return read


def add_environment_options(
    parser: argparse.ArgumentParser, names: Iterable[str] = REPLACEABLE
) -> None:
    """Add the options that replace what champions evolved in, all or some."""
    group = parser.add_argument_group('environment', 'in place of what the champions evolved in')
    for option in (WORLD, *(OPTIONS[name] for name in names)):
        add_option(group, replace(option, default=None), default=argparse.SUPPRESS)


def read_environment(
    program: str, options: argparse.Namespace, champions: Sequence[Champion]
) -> Environment:
    """Return the `Environment` of champions, with the options given; tell what they replace."""
    environment, replaced = choose_environment(champions, vars(options))
    for sentence in replaced:
        print(f'{program}: {sentence}', file=sys.stderr)
    return environment


def add_genome_options(parser: argparse.ArgumentParser) -> None:
    """Add the options --predator and --prey."""
    for species in SPECIES:
        parser.add_argument(
            f'--{species}',
            default='shipped/open',
            metavar='GENOME',
            help=f'{GENOME_HELP} (default: %(default)s)',
        )


def read_champions(options: argparse.Namespace) -> list[Champion]:
    """Return the champions of --predator and --prey; ValueError if there are none such."""
    return [select_champion(getattr(options, species), species) for species in SPECIES]


def any_path(text: str) -> Path:
    """Return a path that the system can look up, whatever is there (argparse type)."""
    if not text:
        raise argparse.ArgumentTypeError('the path is empty, expected one that is not')
    path = Path(text)
    try:
        path.lstat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise argparse.ArgumentTypeError(
                f'{text[:40]!r}... has {len(text)} characters, expected a shorter path'
            ) from None
    return path


def new_path(text: str) -> Path:
    """Return a path where nothing is yet and whose folder exists (argparse type)."""
    path = any_path(text)
    if path.exists():
        raise argparse.ArgumentTypeError(f'{path} exists, expected a new name')
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(
            f'{path.parent} is no folder, expected one for {path.name}'
        )
    return path

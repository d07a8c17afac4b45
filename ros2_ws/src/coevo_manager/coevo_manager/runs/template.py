"""A configuration as a commented file, to be changed and given back to evolve."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import yaml

from coevo_manager.core.evolution import load_configuration
from coevo_manager.core.evolution.fields import all_fields

_HEAD = """\
# Settings of a run, for evolve --config FILE. A line that begins with '#' and a name shows what
# holds without it in the preset {preset}; take the '#' away to change it.
"""
_WIDTH = 96


def make_template(values: Mapping[str, Any], preset: str) -> str:
    """Return YAML that gives the values, and names every other field of the run in a comment.

    Parameters
    ----------
    values : mapping
        Fields of `Configuration` by name.
    preset : str

    Raises
    ------
    ValueError
        One sentence, see `load_configuration`.
    """
    configuration = load_configuration(values, preset).as_dict()
    blocks = [_HEAD.format(preset=preset)]
    fields = all_fields()
    for name in {**configuration, **values}:
        option = fields[name]
        sentence = f'{option.help}: {option.expected}'
        lines = textwrap.wrap(sentence, _WIDTH, initial_indent='# ', subsequent_indent='# ')
        mark = '' if name in values else '#'
        value = yaml.safe_dump({name: configuration.get(name, values.get(name))}).strip()
        blocks.append('\n'.join([*lines, mark + value]) + '\n')
    return '\n'.join(blocks)

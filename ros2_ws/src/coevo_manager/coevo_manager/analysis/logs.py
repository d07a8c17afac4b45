"""Reading the logs of a run, generations.csv and phases.csv."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from coevo_manager.core.species import SPECIES
from neuro_controller.core.reading import read_text, reading

LIMIT = 2**30
"""Bytes of a log: those of some ten million generations."""


def read_log(path: Path, columns: Sequence[str]) -> pd.DataFrame:
    """Read a log and check each value.

    Parameters
    ----------
    path : Path
    columns : sequence of str
        Those that it must have: `evolving`, fitness from 0 to 1, and whole numbers, of which
        generations, phases, episodes and ticks never fall.

    Raises
    ------
    ReadingError
        It is missing or damaged: what, and in which line.
    """
    text = read_text(path, LIMIT)
    with reading(path):
        return parse_log(text, columns)


def parse_log(text: str, columns: Sequence[str]) -> pd.DataFrame:
    """Read the text of a log, as `read_log`; ValueError says what is wrong, and in which line."""
    lines = text.split('\n')
    if lines.pop():
        raise ValueError(f'line {len(lines) + 1} is cut off')
    if not lines or lines[0].split(',') != list(columns):
        raise ValueError(f'line 1 does not name the columns {", ".join(columns)}')
    for number, line in enumerate(lines, 1):
        if line.count(',') != len(columns) - 1:
            raise ValueError(f'line {number} does not have {len(columns)} values')
    table = pd.read_csv(
        io.StringIO(text),
        dtype={name: _kind(name) for name in columns},
        na_filter=False,
        quoting=csv.QUOTE_NONE,
    )
    for name in columns:
        wrong = ~_sound(table[name])
        if wrong.any():
            place = int(wrong.argmax())
            raise ValueError(f'line {place + 2}, {name} is {table[name][place]!s:.40}')
    return table


def turns(table: pd.DataFrame, species: str) -> list[tuple[float, float]]:
    """Return the stretches of generations in which a species evolves, from generations.csv."""
    generation = table['generation'].to_numpy(float)
    mine = np.concatenate([[False], table['evolving'] == species, [False]])
    starts, ends = np.flatnonzero(mine[1:] & ~mine[:-1]), np.flatnonzero(~mine[1:] & mine[:-1])
    return [
        (float(generation[start] - 1), float(generation[end - 1]))
        for start, end in zip(starts, ends, strict=True)
    ]


def _kind(name: str) -> type:
    if name == 'evolving':
        return str
    return float if 'fitness' in name else int


def _sound(values: pd.Series) -> pd.Series:
    if values.name == 'evolving':
        before_evolution = (values.index == 0) & (values == '')
        return values.isin(SPECIES) | before_evolution
    if _kind(str(values.name)) is float:
        return values.between(0, 1)
    if values.name in ('accepted', 'retained'):
        return values >= 0
    return values >= values.shift(fill_value=0)

"""Reading the logs of a run, generations.csv and phases.csv."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coevo_manager.core.species import SPECIES
from neuro_controller.core.reading import read_text, reading

if TYPE_CHECKING:
    import pandas as pd

LIMIT = 2**30
"""Bytes of a log: those of some ten million generations."""


def read_columns(path: Path, columns: Sequence[str]) -> dict[str, np.ndarray]:
    """Read a log and check each value.

    Parameters
    ----------
    path : Path
    columns : sequence of str
        Those that it must have: `evolving`, fitness from 0 to 1, and whole numbers, of which
        generations, phases, episodes and ticks never fall. The first column rises in each line.

    Returns
    -------
    dict of str to array, shape (lines,)
        The columns in order: str, float64 or int64.

    Raises
    ------
    ReadingError
        It is missing or damaged: what, and in which line.
    """
    text = read_text(path, LIMIT)
    with reading(path):
        return _parse(text, columns)


def parse_log(text: str, columns: Sequence[str], first: int = 1) -> pd.DataFrame:
    """Read the text of a log from its line `first` on; line 1 names the columns.

    ValueError says what is wrong, and in which line of the log.
    """
    import pandas as pd  # here: runs are read without it

    return pd.DataFrame(_parse(text, columns, first))


def _parse(text: str, columns: Sequence[str], first: int = 1) -> dict[str, np.ndarray]:
    lines = text.split('\n')
    if lines.pop():
        raise ValueError(f'line {first + len(lines)} is cut off')
    if first == 1:
        if not lines or lines.pop(0).split(',') != list(columns):
            raise ValueError(f'line 1 does not name the columns {", ".join(columns)}')
        first = 2
    for number, line in enumerate(lines, first):
        if line.count(',') != len(columns) - 1:
            raise ValueError(f'line {number} does not have {len(columns)} values')
    written = np.array([line.split(',') for line in lines], str).reshape(-1, len(columns))
    table: dict[str, np.ndarray] = {}
    for name, texts in zip(columns, written.T, strict=True):
        kind = _kind(name)
        try:
            table[name] = texts.astype(kind)
            wrong = ~_sound(name, table[name], rises=name == columns[0])
        except (ValueError, OverflowError):
            wrong = np.array([not _is(kind, text) for text in texts])
        if wrong.any():
            place = int(wrong.argmax())
            raise ValueError(f'line {first + place}, {name} is {texts[place]:.40}')
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


def _is(kind: type, text: str) -> bool:
    try:
        np.array(text).astype(kind)
    except (ValueError, OverflowError):
        return False
    return True


def _sound(name: str, values: np.ndarray, rises: bool) -> np.ndarray:
    if name == 'evolving':
        before_evolution = (np.arange(len(values)) == 0) & (values == '')
        return np.isin(values, SPECIES) | before_evolution
    if _kind(name) is float:
        return (values >= 0) & (values <= 1)
    if name in ('accepted', 'retained'):
        return values >= 0
    return np.diff(values, prepend=-1) > 0 if rises else np.diff(values, prepend=0) >= 0

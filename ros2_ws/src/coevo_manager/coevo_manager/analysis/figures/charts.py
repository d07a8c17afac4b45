"""What a figure shows, apart from how it is drawn: once for print, once for the screen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from coevo_manager.analysis.conditions import slug

MARKERS = {'predator': 'triangle', 'prey': 'circle'}
# Okabe & Ito's palette, for conditions; the marker tells them apart in grey.
CONDITION_COLOURS = ('#000000', '#e69f00', '#0072b2', '#cc79a7', '#009e73', '#56b4e9')
CONDITION_MARKERS = ('circle', 'square', 'triangle', 'diamond', 'cross', 'star')


@dataclass
class Line:
    """A curve, with an interval where `low` and `high` are given."""

    x: ArrayLike
    y: ArrayLike
    name: str
    colour: str
    dashed: bool = False
    marker: str | None = None
    low: ArrayLike | None = None
    high: ArrayLike | None = None
    thin: bool = False
    in_legend: bool = True


@dataclass
class Spans:
    """Stretches of the x axis that are shaded; each is (start, end)."""

    spans: Sequence[tuple[float, float]]
    name: str
    colour: str


@dataclass
class Points:
    """A cloud of points; `text` is shown when the pointer is over one.

    Where `path` is true, a line leads from each to the next, the points grow along it, and the
    first and the last are named by their text.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    colour: str
    marker: str
    text: Sequence[str] | None = None
    low: ArrayLike | None = None
    high: ArrayLike | None = None
    path: bool = False


@dataclass
class Bars:
    """Bars over named groups, with intervals."""

    groups: Sequence[str]
    y: ArrayLike
    name: str
    colour: str
    hatched: bool = False
    low: ArrayLike | None = None
    high: ArrayLike | None = None


@dataclass
class Heat:
    """A matrix as colours: `z[row, column]`, row along y, from 0 (dark) to 1 (bright)."""

    x: ArrayLike
    y: ArrayLike
    z: np.ndarray
    label: str


Mark = Line | Spans | Points | Bars | Heat


@dataclass
class Panel:
    """One pair of axes; `note` stands in a corner of it."""

    title: str
    xlabel: str
    ylabel: str
    marks: Sequence[Mark]
    ylim: tuple[float, float] | None = None
    xlim: tuple[float, float] | None = None
    zero: bool = False
    categories: Sequence[str] | None = None
    note: str = ''


@dataclass
class Chart:
    """A figure: panels in rows.

    Attributes
    ----------
    kind : str
        What it shows, such as 'master_tournament'.
    title, caption : str
    rows : list of list of Panel
    arena : str, optional
        Of the conditions in it; None where it compares arenas.
    note : str
        What bands and bars mean; it stands in the picture.
    height : float
        Of a row of panels, in inches.
    """

    kind: str
    title: str
    caption: str
    rows: list[list[Panel]]
    arena: str | None = None
    note: str = ''
    height: float = 2.3

    @property
    def name(self) -> str:
        """Name of its files."""
        return self.kind if self.arena is None else f'{self.kind}_{slug(self.arena)}'

    @property
    def panels(self) -> list[Panel]:
        """All panels, row by row."""
        return [panel for row in self.rows for panel in row]

    @property
    def legend(self) -> dict[str, Line | Spans | Points | Bars]:
        """Marks to explain, by name, the first of each."""
        found: dict[str, Line | Spans | Points | Bars] = {}
        for panel in self.panels:
            for mark in panel.marks:
                if not isinstance(mark, Heat) and getattr(mark, 'in_legend', True):
                    found.setdefault(mark.name, mark)
        return found

    @property
    def scale(self) -> Heat | None:
        """A mark whose colours are explained by one bar for all panels, if there is one."""
        marks = (mark for panel in self.panels for mark in panel.marks)
        return next((mark for mark in marks if isinstance(mark, Heat)), None)

"""What a figure shows, apart from how it is drawn: once for print, once for the screen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MARKERS = {'predator': 'triangle', 'prey': 'circle'}
# Okabe & Ito's palette, for conditions; the marker tells them apart in grey.
CONDITION_COLOURS = ('#000000', '#e69f00', '#0072b2', '#cc79a7', '#009e73', '#56b4e9')
CONDITION_MARKERS = ('circle', 'square', 'triangle', 'diamond', 'cross', 'star')


@dataclass
class Line:
    """A curve, with an interval where `low` and `high` are given."""

    x: Sequence
    y: Sequence
    name: str
    colour: str
    dashed: bool = False
    marker: str | None = None
    low: Sequence | None = None
    high: Sequence | None = None
    thin: bool = False
    in_legend: bool = True


@dataclass
class Points:
    """A cloud of points; `text` is shown when the pointer is over one."""

    x: Sequence
    y: Sequence
    name: str
    colour: str
    marker: str
    text: Sequence[str] | None = None
    low: Sequence | None = None
    high: Sequence | None = None
    in_legend: bool = True


@dataclass
class Bars:
    """Bars over named groups, with intervals and the single replications as dots."""

    groups: Sequence[str]
    y: Sequence
    name: str
    colour: str
    hatched: bool = False
    low: Sequence | None = None
    high: Sequence | None = None


@dataclass
class Heat:
    """A matrix as colours: `z[row, column]`, row along y."""

    x: Sequence
    y: Sequence
    z: np.ndarray
    label: str
    low: float = 0.0
    high: float = 1.0
    diverging: bool = False


@dataclass
class Panel:
    """One pair of axes."""

    title: str
    xlabel: str
    ylabel: str
    marks: list
    ylim: tuple[float, float] | None = None
    zero: bool = False
    categories: Sequence[str] | None = None


@dataclass
class Chart:
    """A figure: panels in rows, a title and a caption."""

    name: str
    title: str
    caption: str
    rows: list[list[Panel]]
    height: float = 2.3

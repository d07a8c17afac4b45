"""Draw charts for print: matplotlib, PNG and SVG."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from PIL import Image

from coevo_manager.analysis.figures.charts import Bars, Chart, Heat, Line, Panel, Points, Spans
from coevo_manager.core.evolution.files import write_whole

STYLE: Any = {
    'font.size': 8,
    'axes.titlesize': 8.5,
    'axes.titleweight': 'bold',
    'axes.labelsize': 8,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.linewidth': 0.7,
    'axes.grid': True,
    'axes.axisbelow': True,
    'grid.color': '#e3e3e3',
    'grid.linewidth': 0.5,
    'xtick.labelsize': 7,
    'ytick.labelsize': 7,
    'legend.fontsize': 7.5,
    'legend.frameon': False,
    'lines.linewidth': 1.3,
    'hatch.linewidth': 0.8,
    'svg.hashsalt': 'red-queen',
}
MARKS = {
    'circle': 'o',
    'square': 's',
    'triangle': '^',
    'diamond': 'D',
    'cross': 'X',
    'star': '*',
}
WIDTH = 7.0  # inches, two columns of a journal
COLOURS_OF_HEAT = 'viridis'


def thousands(value: float) -> str:
    """A generation, short: 0, 500, 10k, 150k."""
    return f'{value / 1000:g}k' if abs(value) >= 10_000 else f'{value:g}'


def draw(chart: Chart) -> Figure:
    """A chart as a matplotlib figure."""
    with mpl.rc_context(STYLE):
        columns = max(len(row) for row in chart.rows)
        width = WIDTH if columns > 1 else 4.2
        figure = Figure(figsize=(width, chart.height * len(chart.rows) + 0.5))
        figure.set_layout_engine('constrained', h_pad=0.06)
        grid = figure.add_gridspec(len(chart.rows), columns)
        handles: dict[str, Any] = {}
        all_axes = []
        for r, row in enumerate(chart.rows):
            for c, panel in enumerate(row):
                axes = figure.add_subplot(grid[r, c])
                handles |= draw_panel(axes, panel)
                all_axes.append(axes)
        if chart.scale is not None:
            figure.colorbar(
                ScalarMappable(Normalize(0, 1), COLOURS_OF_HEAT),
                ax=all_axes,
                label=chart.scale.label,
                fraction=0.03,
                shrink=0.8,
                aspect=30,
                pad=0.02,
            )
        shown = {name: handles[name] for name in chart.legend if name in handles}
        if shown:
            figure.legend(
                shown.values(),
                shown.keys(),
                loc='outside lower center',
                ncols=min(len(shown), 5, max(1, 110 // (max(map(len, shown)) + 6))),
                title=chart.note or None,
                title_fontsize=7,
            )
        elif chart.note:
            figure.supxlabel(chart.note, fontsize=7)
    return figure


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write STEM.png (200 dpi) and STEM.svg."""
    paths = stem.with_name(f'{stem.name}.png'), stem.with_name(f'{stem.name}.svg')
    with mpl.rc_context(STYLE):
        for path in paths:
            image = io.BytesIO()
            date = {'Date': None} if path.suffix == '.svg' else None
            figure.savefig(image, format=path.suffix[1:], dpi=200, metadata=date)
            figure.set_layout_engine('none')  # the places are found once
            write_whole(path, _small(image) if path.suffix == '.png' else image.getvalue())
    return paths


def _small(image: io.BytesIO) -> bytes:
    """The same PNG with a palette of 256 colours, a third of the size."""
    small = io.BytesIO()
    with Image.open(image) as picture:
        picture.convert('RGB').quantize(256, dither=Image.Dither.NONE).save(small, 'png')
    return small.getvalue()


def draw_panel(axes: Axes, panel: Panel) -> dict[str, Any]:
    """Draw one panel; returns legend handles by name."""
    handles = {}
    bars = [mark for mark in panel.marks if isinstance(mark, Bars)]
    for mark in panel.marks:
        if isinstance(mark, Heat):
            _heat(axes, mark)
        elif isinstance(mark, Bars):
            place = next(k for k, each in enumerate(bars) if each is mark)
            handles[mark.name] = _bars(axes, mark, place, len(bars))
        elif isinstance(mark, Spans):
            handles[mark.name] = _spans(axes, mark)
        else:
            handle = _line(axes, mark) if isinstance(mark, Line) else _points(axes, mark)
            handles.setdefault(mark.name, handle)
    if panel.zero:
        axes.axhline(0, color='#888888', linewidth=0.8, zorder=1)
    if panel.ylim:
        axes.set_ylim(*panel.ylim)
    if panel.xlim:
        axes.set_xlim(*panel.xlim)
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel)
    axes.set_title(panel.title, loc='left')
    if panel.note:
        axes.text(
            0.03, 0.97, panel.note, transform=axes.transAxes, va='top', fontsize=6.5, zorder=5,
            bbox={'facecolor': 'white', 'alpha': 0.8, 'edgecolor': 'none', 'pad': 1.5},
        )  # fmt: skip
    if panel.categories is not None:
        _name_ticks(axes, panel.categories)
        axes.set_xlim(-0.5, len(panel.categories) - 0.5)
    elif not bars:
        _numbers(axes.xaxis, 4)
    return handles


def _numbers(axis: Any, ticks: int) -> None:
    axis.set_major_locator(MaxNLocator(ticks))
    axis.set_major_formatter(FuncFormatter(lambda value, _: thousands(value)))


def _line(axes: Axes, mark: Line) -> Any:
    if mark.low is not None and mark.high is not None:
        axes.fill_between(mark.x, mark.low, mark.high, color=mark.colour, alpha=0.18, linewidth=0)
    (handle,) = axes.plot(
        mark.x,
        mark.y,
        color=mark.colour,
        linestyle=(0, (4, 1.6)) if mark.dashed else '-',
        linewidth=0.5 if mark.thin else 1.4,
        alpha=0.5 if mark.thin else 1,
        marker=MARKS[mark.marker] if mark.marker else None,
        markersize=3.5,
        markeredgewidth=0,
    )
    return handle


def _spans(axes: Axes, mark: Spans) -> Any:
    widths = [(start, end - start) for start, end in mark.spans]
    handle = axes.broken_barh(
        widths, (0, 1), color=mark.colour, alpha=0.16, linewidth=0,
        transform=axes.get_xaxis_transform(),
    )  # fmt: skip
    handle.set_zorder(0)
    return handle


def _points(axes: Axes, mark: Points) -> Any:
    x, y = np.asarray(mark.x, float), np.asarray(mark.y, float)
    sizes: Any = 18
    if mark.low is not None and mark.high is not None:
        axes.errorbar(
            x, y, _around(mark), fmt='none', ecolor=mark.colour, elinewidth=1.2, capsize=2.5
        )
    if mark.path:
        axes.plot(x, y, color=mark.colour, linewidth=0.6, alpha=0.6)
        sizes = np.linspace(6, 30, len(x))
        for place, text in zip((0, -1), _ends(mark), strict=True):
            axes.annotate(
                text, (x[place], y[place]), (3, 3), textcoords='offset points', fontsize=5.5,
                color=mark.colour, zorder=4,
            )  # fmt: skip
    return axes.scatter(
        x, y, s=sizes, color=mark.colour, marker=MARKS[mark.marker], linewidths=0, zorder=3
    )


def _ends(mark: Points) -> tuple[str, str]:
    return (mark.text[0], mark.text[-1]) if mark.text else ('', '')


def _bars(axes: Axes, mark: Bars, place: int, count: int) -> Any:
    width = 0.8 / count
    x = np.arange(len(mark.groups)) - 0.4 + width * (place + 0.5)
    handle = axes.bar(
        x,
        mark.y,
        width * 0.92,
        color=mark.colour,
        hatch='////' if mark.hatched else None,
        edgecolor='white',
        linewidth=0,
    )
    if mark.low is not None:
        axes.errorbar(
            x, mark.y, _around(mark), fmt='none', ecolor='#222222', elinewidth=0.9, capsize=2.5
        )
    _name_ticks(axes, mark.groups)
    return handle


def _name_ticks(axes: Axes, names: Sequence[str]) -> None:
    """Write names below the axis in place of a grid: a word a line, or slanted where many."""
    many = sum(map(len, names)) > 60
    slant: dict[str, Any] = (
        {'rotation': 40, 'ha': 'right', 'rotation_mode': 'anchor'} if many else {}
    )
    labels = names if many else [name.replace(' ', '\n') for name in names]
    axes.set_xticks(range(len(names)), labels, **slant)
    axes.grid(axis='x', visible=False)


def _around(mark: Points | Bars) -> np.ndarray:
    y = np.asarray(mark.y, float)
    return np.abs([y - np.asarray(mark.low, float), np.asarray(mark.high, float) - y])


def _heat(axes: Axes, mark: Heat) -> None:
    x, y = edges(mark.x), edges(mark.y)
    axes.pcolormesh(x, y, mark.z, cmap=COLOURS_OF_HEAT, vmin=0, vmax=1, rasterized=True)
    _numbers(axes.yaxis, 4)
    axes.grid(visible=False)
    axes.set_box_aspect(1)


def edges(places: Any) -> np.ndarray:
    """Borders of the cells around places, halfway between neighbours, (n + 1,)."""
    places = np.asarray(places, float)
    if len(places) < 2:
        return places[0] + np.array([-0.5, 0.5])
    middles = (places[1:] + places[:-1]) / 2
    first, last = places[0] - (middles[0] - places[0]), places[-1] + (places[-1] - middles[-1])
    return np.concatenate([[first], middles, [last]])


def draw_all(
    charts: list[Chart], folder: Path, advance: Callable[[int], object]
) -> list[tuple[Chart, Path]]:
    """Draw each chart to a folder; returns them with their SVG."""
    drawn = []
    for chart in charts:
        drawn.append((chart, save(draw(chart), folder / chart.name)[1]))
        advance(1)
    return drawn

"""Draw charts for print: matplotlib, PNG and SVG."""

import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from coevo_manager.analysis.figures.charts import Bars, Chart, Heat, Line, Panel, Points
from coevo_manager.core.evolution.files import write_whole

STYLE = {
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


def thousands(value: float) -> str:
    """A generation, short: 0, 500, 10k, 150k."""
    return f'{value / 1000:g}k' if abs(value) >= 10_000 else f'{value:g}'


def draw(chart: Chart) -> Figure:
    """A chart as a matplotlib figure."""
    with mpl.rc_context(STYLE):
        columns = max(len(row) for row in chart.rows)
        width = WIDTH if columns > 1 else 4.2
        figure = Figure(
            figsize=(width, chart.height * len(chart.rows) + 0.35), layout='constrained'
        )
        grid = figure.add_gridspec(len(chart.rows), columns)
        handles = {}
        for r, row in enumerate(chart.rows):
            for c, panel in enumerate(row):
                axes = figure.add_subplot(grid[r, c])
                handles |= draw_panel(axes, panel)
        if handles:
            figure.legend(
                handles.values(),
                handles.keys(),
                loc='outside lower center',
                ncols=min(len(handles), 5),
            )
    return figure


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write STEM.png (200 dpi) and STEM.svg."""
    paths = stem.with_name(f'{stem.name}.png'), stem.with_name(f'{stem.name}.svg')
    for path in paths:
        image = io.BytesIO()
        with mpl.rc_context(STYLE):
            date = {'Date': None} if path.suffix == '.svg' else None
            figure.savefig(image, format=path.suffix[1:], dpi=200, metadata=date)
        write_whole(path, image.getvalue())
    return paths


def draw_panel(axes, panel: Panel) -> dict:
    """Draw one panel; returns legend handles by name."""
    handles = {}
    bars = [mark for mark in panel.marks if isinstance(mark, Bars)]
    for mark in panel.marks:
        if isinstance(mark, Heat):
            _heat(axes, mark)
        elif isinstance(mark, Bars):
            place = next(k for k, each in enumerate(bars) if each is mark)
            handles[mark.name] = _bars(axes, mark, place, len(bars))
        else:
            handle = _line(axes, mark) if isinstance(mark, Line) else _points(axes, mark)
            if mark.in_legend:
                handles[mark.name] = handle
    if panel.zero:
        axes.axhline(0, color='#888888', linewidth=0.8, zorder=1)
    if panel.ylim:
        axes.set_ylim(*panel.ylim)
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel)
    axes.set_title(panel.title, loc='left')
    if panel.categories is not None:
        axes.set_xticks(range(len(panel.categories)), panel.categories)
        axes.set_xlim(-0.5, len(panel.categories) - 0.5)
        axes.grid(axis='x', visible=False)
    elif not bars and not any(isinstance(mark, Heat) for mark in panel.marks):
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: thousands(value)))
    return handles


def _line(axes, mark: Line):
    if mark.low is not None:
        axes.fill_between(mark.x, mark.low, mark.high, color=mark.colour, alpha=0.18, linewidth=0)
    (handle,) = axes.plot(
        mark.x,
        mark.y,
        color=mark.colour,
        linestyle=(0, (4, 1.6)) if mark.dashed else '-',
        linewidth=0.6 if mark.thin else 1.4,
        alpha=0.45 if mark.thin else 1,
        marker=MARKS[mark.marker] if mark.marker else None,
        markersize=3.5,
        markeredgewidth=0,
    )
    return handle


def _points(axes, mark: Points):
    if mark.low is not None:
        spans = np.abs([np.subtract(mark.y, mark.low), np.subtract(mark.high, mark.y)])
        axes.errorbar(
            mark.x, mark.y, spans, fmt='none', ecolor=mark.colour, elinewidth=1.2, capsize=2.5
        )
    return axes.scatter(
        mark.x, mark.y, s=18, color=mark.colour, marker=MARKS[mark.marker], linewidths=0, zorder=3
    )


def _bars(axes, mark: Bars, place: int, count: int):
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
        spans = np.abs([np.subtract(mark.y, mark.low), np.subtract(mark.high, mark.y)])
        axes.errorbar(x, mark.y, spans, fmt='none', ecolor='#222222', elinewidth=0.9, capsize=2.5)
    axes.set_xticks(range(len(mark.groups)), mark.groups)
    axes.grid(axis='x', visible=False)
    return handle


def _heat(axes, mark: Heat) -> None:
    image = axes.pcolormesh(
        np.arange(len(mark.x) + 1),
        np.arange(len(mark.y) + 1),
        mark.z,
        cmap='PuOr' if mark.diverging else 'viridis',
        vmin=mark.low,
        vmax=mark.high,
        edgecolors='face',
        linewidth=0.3,
    )
    for axis, values in ((axes.xaxis, mark.x), (axes.yaxis, mark.y)):
        step = -(-len(values) // 4)
        places = range(0, len(values), step)
        axis.set_ticks([p + 0.5 for p in places], [thousands(values[p]) for p in places])
    axes.grid(visible=False)
    axes.set_aspect('equal')
    axes.figure.colorbar(image, ax=axes, shrink=0.75, pad=0.02, label=mark.label)

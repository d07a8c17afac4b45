"""Charts for the screen: panels as Plotly figures in plain JSON, to zoom and hover.

A page lays the panels out and writes the legend, so that they fit any width; `charts.js` draws.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex

from coevo_manager.analysis.figures.charts import (
    Bars,
    Chart,
    Heat,
    Line,
    Mark,
    Panel,
    Points,
    Spans,
)
from coevo_manager.analysis.figures.draw import COLOURS_OF_HEAT

MARKS = {
    'circle': 'circle',
    'square': 'square',
    'triangle': 'triangle-up',
    'diamond': 'diamond',
    'cross': 'x',
    'star': 'star',
}
SYMBOLS = {
    'circle': '●',
    'square': '■',
    'triangle': '▲',
    'diamond': '◆',
    'cross': '✖',
    'star': '★',
}
INCH = 95
"""Pixels of an inch of the printed panel."""


def chart_data(chart: Chart) -> dict[str, Any]:
    """A chart as `charts.js` takes it: its panels, their columns, a legend and a scale."""
    return {
        'columns': max(len(row) for row in chart.rows),
        'panels': [panel_figure(panel, chart.height) for panel in chart.panels],
        'legend': [_legend(name, mark) for name, mark in chart.legend.items()],
        'scale': _scale(chart.scale),
        'note': chart.note,
    }


def panel_figure(panel: Panel, height: float) -> dict[str, Any]:
    """A panel as a Plotly figure: `data` and `layout`, and a title and a note."""
    heat = any(isinstance(mark, Heat) for mark in panel.marks)
    axis: dict[str, Any] = {'zeroline': False, 'ticks': 'outside'}
    axis |= {'automargin': True, 'nticks': 6}
    x = axis | {'title': {'text': panel.xlabel, 'standoff': 6}}
    y = axis | {'title': {'text': panel.ylabel, 'standoff': 6}}
    if panel.ylim:
        y['range'] = list(panel.ylim)
    if panel.xlim:
        x['range'] = _numbers(panel.xlim)
    if panel.zero:
        y |= {'zeroline': True, 'rangemode': 'tozero'}
    if panel.categories is not None:
        count = len(panel.categories)
        x |= {'tickvals': list(range(count)), 'ticktext': list(panel.categories)}
        x['range'] = [-0.5, count - 0.5]
    layout = {
        'height': round(INCH * height) + 93,
        'margin': {'l': 52, 'r': 8, 't': 26, 'b': 44},
        'font': {'family': 'system-ui, sans-serif', 'size': 12},
        'hovermode': 'closest',
        'showlegend': False,
        'barmode': 'group',
        'xaxis': x,
        'yaxis': y,
        'shapes': [
            shape for mark in panel.marks if isinstance(mark, Spans) for shape in _shapes(mark)
        ],
    }
    traces = [trace for mark in panel.marks for trace in _traces(mark)]
    return {
        'title': panel.title,
        'note': panel.note,
        'square': heat,
        'data': traces,
        'layout': layout,
    }


def _legend(name: str, mark: Line | Spans | Points | Bars) -> dict[str, str]:
    symbol = '■'
    if isinstance(mark, Spans):
        symbol = '▒'
    elif not isinstance(mark, Bars):
        symbol = SYMBOLS[mark.marker] if mark.marker else '━'
        symbol += '┅' if isinstance(mark, Line) and mark.dashed else ''
    return {'name': name, 'colour': mark.colour, 'symbol': symbol}


def _scale(mark: Heat | None) -> dict[str, Any] | None:
    if mark is None:
        return None
    colours = [to_hex(colormaps[COLOURS_OF_HEAT](k / 8)) for k in range(9)]
    return {'label': mark.label, 'low': 0, 'high': 1, 'colours': colours}


def _shapes(mark: Spans) -> list[dict[str, Any]]:
    common = {'type': 'rect', 'yref': 'paper', 'y0': 0, 'y1': 1, 'layer': 'below'}
    look = {'fillcolor': mark.colour, 'opacity': 0.16, 'line': {'width': 0}}
    return [common | look | {'x0': start, 'x1': end} for start, end in mark.spans]


def _traces(mark: Mark) -> list[dict[str, Any]]:
    if isinstance(mark, Spans):
        return []
    if isinstance(mark, Heat):
        return [
            {
                'type': 'heatmap',
                'x': _numbers(mark.x),
                'y': _numbers(mark.y),
                'z': _numbers(mark.z),
                'zmin': 0,
                'zmax': 1,
                'colorscale': COLOURS_OF_HEAT.capitalize(),
                'showscale': False,
                'hovertemplate': 'column %{x}<br>row %{y}<br>%{z:.3f}<extra></extra>',
            }
        ]
    common: dict[str, Any] = {'name': mark.name, 'y': _numbers(mark.y)}
    if isinstance(mark, Bars):
        pattern = {'shape': '/' if mark.hatched else '', 'fillmode': 'overlay', 'fgcolor': '#fff'}
        look = {'color': mark.colour, 'pattern': pattern}
        bars = common | {'type': 'bar', 'x': list(mark.groups), 'marker': look}
        return [bars | _interval(mark, '#222')]
    common |= {'type': 'scatter'} | _places(mark.x)
    return _points(mark, common) if isinstance(mark, Points) else _line(mark, common)


def _points(mark: Points, common: dict[str, Any]) -> list[dict[str, Any]]:
    count = len(np.asarray(mark.x))
    size: Any = np.linspace(5, 12, count).round(1).tolist() if mark.path else 8
    look = {'color': mark.colour, 'symbol': MARKS[mark.marker], 'size': size}
    points = common | {'mode': 'lines+markers' if mark.path else 'markers', 'marker': look}
    points['line'] = {'color': mark.colour, 'width': 0.7}
    if mark.text is not None:
        points |= {
            'text': list(mark.text),
            'hovertemplate': f'{mark.name} %{{text}}<br>%{{x:.4g}}, %{{y:.4g}}<extra></extra>',
        }
    return [points | _interval(mark, mark.colour)]


def _line(mark: Line, common: dict[str, Any]) -> list[dict[str, Any]]:
    line = common | {
        'mode': 'lines+markers' if mark.marker else 'lines',
        'line': {
            'color': mark.colour,
            'dash': 'dash' if mark.dashed else 'solid',
            'width': 0.7 if mark.thin else 2,
        },
        'opacity': 0.45 if mark.thin else 1,
    }
    if mark.marker:
        line['marker'] = {'symbol': MARKS[mark.marker], 'size': 6}
    if mark.low is None or mark.high is None:
        return [line]
    x, low, high = (np.asarray(values, float) for values in (mark.x, mark.low, mark.high))
    known = np.isfinite(low) & np.isfinite(high)
    band = {
        'type': 'scatter',
        'mode': 'lines',
        'x': _numbers(np.concatenate([x[known], x[known][::-1]])),
        'y': _numbers(np.concatenate([high[known], low[known][::-1]])),
        'fill': 'toself',
        'fillcolor': mark.colour,
        'opacity': 0.16,
        'line': {'width': 0},
        'hoverinfo': 'skip',
    }
    return [band, line]


def _interval(mark: Points | Bars, colour: str) -> dict[str, Any]:
    if mark.low is None or mark.high is None:
        return {}
    return {
        'error_y': {
            'type': 'data',
            'symmetric': False,
            'array': _numbers(np.subtract(mark.high, mark.y)),
            'arrayminus': _numbers(np.subtract(mark.y, mark.low)),
            'color': colour,
        }
    }


def _places(x: Any) -> dict[str, Any]:
    """Values along x, short where they are evenly spaced."""
    values = np.asarray(x, float)
    steps = np.diff(values)
    if len(steps) > 8 and (steps == steps[0]).all():
        return {'x0': float(values[0]), 'dx': float(steps[0])}
    return {'x': _numbers(values)}


def _numbers(values: Any) -> list[Any]:
    """JSON numbers with 4 significant digits; None for what is not a number."""
    array = np.asarray(values, float)
    if array.ndim == 2:
        return [_numbers(row) for row in array]
    whole = array == np.round(array)
    return [
        None if not np.isfinite(v) else int(v) if w else float(f'{v:.4g}')
        for v, w in zip(array.tolist(), whole.tolist(), strict=True)
    ]

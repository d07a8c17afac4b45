"""Charts for the screen: Plotly figures as plain JSON, to zoom and hover."""

import numpy as np

from coevo_manager.analysis.figures.charts import Bars, Chart, Heat, Line, Panel, Points

MARKS = {
    'circle': 'circle',
    'square': 'square',
    'triangle': 'triangle-up',
    'diamond': 'diamond',
    'cross': 'x',
    'star': 'star',
}


TOP, BETWEEN, BOTTOM = 35, 85, 95  # px: modebar and titles, axis titles, axis title and legend
PANEL = 95  # px an inch of the printed panel


def figure(chart: Chart) -> dict:
    """A chart as a Plotly figure: `data` and `layout`."""
    columns = max(len(row) for row in chart.rows)
    rows = len(chart.rows)
    panel = PANEL * chart.height
    inner = rows * panel + (rows - 1) * BETWEEN
    layout: dict = {
        'height': round(inner) + TOP + BOTTOM,
        'margin': {'l': 60, 'r': 15, 't': TOP, 'b': BOTTOM},
        'font': {'family': 'system-ui, sans-serif', 'size': 12, 'color': '#222'},
        'plot_bgcolor': '#fff',
        'paper_bgcolor': '#fff',
        'hovermode': 'closest',
        'legend': {
            'orientation': 'h',
            'x': 0.5,
            'xanchor': 'center',
            'y': -55 / inner,
            'yanchor': 'top',
        },
        'annotations': [],
        'barmode': 'group',
    }
    data: list[dict] = []
    named: set[str] = set()
    gap = 0.09 if columns > 1 else 0
    width = (1 - gap * (columns - 1)) / columns
    depth = panel / inner
    places = [(r, c, panel) for r, row in enumerate(chart.rows) for c, panel in enumerate(row)]
    for number, (r, c, panel) in enumerate(places, 1):
        left, bottom = c * (width + gap), 1 - depth - r * (depth + BETWEEN / inner)
        _add_axes(layout, panel, '' if number == 1 else str(number), left, bottom, width, depth)
        for mark in panel.marks:
            for trace in _traces(mark, left + width * 0.89, bottom + depth / 2, depth):
                trace |= {'xaxis': f'x{number}', 'yaxis': f'y{number}'}
                if 'legendgroup' in trace:
                    name = trace['legendgroup']
                    trace['showlegend'] = trace.get('showlegend', True) and name not in named
                    if trace['showlegend']:
                        named.add(name)
                data.append(trace)
    return {'data': data, 'layout': layout}


def _add_axes(layout: dict, panel: Panel, end: str, left, bottom, width, depth) -> None:
    heat = any(isinstance(mark, Heat) for mark in panel.marks)
    axis = {'gridcolor': '#e8e8e8', 'zeroline': False, 'linecolor': '#999', 'ticks': 'outside'}
    x = axis | {
        'domain': [left, left + width * (0.88 if heat else 1)],
        'anchor': f'y{end}',
        'title': {'text': panel.xlabel, 'standoff': 8},
    }
    y = axis | {
        'domain': [bottom, bottom + depth],
        'anchor': f'x{end}',
        'title': {'text': panel.ylabel, 'standoff': 8},
    }
    if panel.ylim:
        y['range'] = list(panel.ylim)
    if panel.zero:
        y |= {'zeroline': True, 'zerolinecolor': '#888', 'rangemode': 'tozero'}
    if heat:
        x |= {'type': 'category', 'nticks': 6}
        y |= {'type': 'category', 'nticks': 6}
    if panel.categories is not None:
        count = len(panel.categories)
        x |= {'tickvals': list(range(count)), 'ticktext': list(panel.categories)}
        x['range'] = [-0.5, count - 0.5]
    layout[f'xaxis{end}'], layout[f'yaxis{end}'] = x, y
    layout['annotations'].append(
        {
            'text': f'<b>{panel.title}</b>',
            'x': left,
            'y': bottom + depth,
            'xref': 'paper',
            'yref': 'paper',
            'xanchor': 'left',
            'yanchor': 'bottom',
            'showarrow': False,
        }
    )


def _traces(mark, right: float, middle: float, depth: float) -> list[dict]:
    if isinstance(mark, Heat):
        return [
            {
                'type': 'heatmap',
                'x': [str(x) for x in mark.x],
                'y': [str(y) for y in mark.y],
                'z': _numbers(mark.z),
                'zmin': mark.low,
                'zmax': mark.high,
                'colorscale': 'PuOr' if mark.diverging else 'Viridis',
                'colorbar': {
                    'x': right,
                    'y': middle,
                    'len': depth,
                    'thickness': 10,
                    'title': {'text': mark.label, 'side': 'right'},
                },
                'hovertemplate': 'column %{x}<br>row %{y}<br>%{z:.3f}<extra></extra>',
            }
        ]
    common = {'name': mark.name, 'legendgroup': mark.name, 'y': _numbers(mark.y)}
    if isinstance(mark, Bars):
        pattern = {'shape': '/' if mark.hatched else '', 'fillmode': 'overlay', 'fgcolor': '#fff'}
        bars = common | {
            'type': 'bar',
            'x': list(mark.groups),
            'marker': {'color': mark.colour, 'pattern': pattern},
        }
        return [bars | _interval(mark)]
    common |= {'type': 'scatter', 'x': _numbers(mark.x), 'showlegend': mark.in_legend}
    if isinstance(mark, Points):
        style = {'color': mark.colour, 'symbol': MARKS[mark.marker], 'size': 8}
        points = common | {'mode': 'markers', 'marker': style}
        if mark.text is not None:
            points |= {'text': list(mark.text), 'hovertemplate': '%{text}<br>%{x:.4g}, %{y:.4g}'}
        return [points | _interval(mark)]
    return _line(mark, common)


def _line(mark: Line, common: dict) -> list[dict]:
    line = common | {
        'mode': 'lines+markers' if mark.marker else 'lines',
        'line': {
            'color': mark.colour,
            'dash': 'dash' if mark.dashed else 'solid',
            'width': 1 if mark.thin else 2,
        },
        'opacity': 0.45 if mark.thin else 1,
    }
    if mark.marker:
        line['marker'] = {'symbol': MARKS[mark.marker], 'size': 6}
    if mark.low is None:
        return [line]
    band = {
        'type': 'scatter',
        'mode': 'lines',
        'x': _numbers(mark.x) + _numbers(mark.x)[::-1],
        'y': _numbers(mark.high) + _numbers(mark.low)[::-1],
        'fill': 'toself',
        'fillcolor': mark.colour,
        'opacity': 0.16,
        'line': {'width': 0},
        'hoverinfo': 'skip',
        'legendgroup': mark.name,
        'showlegend': False,
    }
    return [band, line]


def _interval(mark) -> dict:
    if mark.low is None:
        return {}
    return {
        'error_y': {
            'type': 'data',
            'symmetric': False,
            'array': _numbers(np.subtract(mark.high, mark.y)),
            'arrayminus': _numbers(np.subtract(mark.y, mark.low)),
            'color': '#222' if isinstance(mark, Bars) else mark.colour,
        }
    }


def _numbers(values) -> list:
    """JSON numbers with 5 significant digits; None for what is not a number."""
    if np.ndim(values) == 2:
        return [_numbers(row) for row in values]
    return [float(f'{v:.5g}') if np.isfinite(v) else None for v in np.asarray(values, float)]

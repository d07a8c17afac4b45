"""report.html: the answer, figures, an episode player, tables and provenance on one page."""

import base64
import json
import zlib
from dataclasses import dataclass
from importlib import metadata
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment as Templates
from plotly.offline import get_plotlyjs

from coevo_manager.analysis.conditions import slug
from coevo_manager.analysis.figures import interactive
from coevo_manager.analysis.figures.charts import Chart
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.report.games import sentences
from coevo_manager.analysis.report.methods import METHODS, TABLES
from coevo_manager.analysis.report.tables import Table
from coevo_manager.analysis.study import Study
from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.core.species import COLOURS, PLURAL

PACKAGES = ('coevo_manager', 'numpy', 'numba', 'scipy', 'statsmodels', 'matplotlib', 'plotly')
ASSETS = (
    *('report.html', 'report.css', 'charts.css', 'player.css'),
    *('charts.js', 'arena.js', 'player.js', 'report.js'),
)
AT_A_GLANCE = 'gains'
"""Kind of the chart that stands beside the verdicts."""

GAMES = ('nash_averaging', 'alpha_rank', 'meta_exploitability', 'effective_diversity')
"""Tables of what game theory says, told in sentences beside the verdicts."""

CHIPS = {
    'progress': ('progress', '▲'),
    'cyclic': ('none', '\N{CLOCKWISE OPEN CIRCLE ARROW}'),
    'retrogression': ('retrogression', '▼'),
    'not significant': ('none', '\N{EN DASH}'),
    'no change': ('none', '='),
    'cannot be claimed': ('unknown', '?'),
}


@dataclass
class Picture:
    """A figure that is only drawn for print."""

    name: str
    title: str
    caption: str
    svg: Path
    arena: str


def write_report(
    path: Path,
    study: Study,
    charts: list[tuple[Chart, Path]],
    pictures: list[Picture],
    tables: dict[str, Table],
    player: list[dict[str, Any]],
) -> None:
    """Write the page.

    Parameters
    ----------
    charts : list of (Chart, Path)
        Each chart with its SVG.
    tables : dict
        Tables by name, of which those of the kinds in `methods.TABLES` are shown.
    player : list of dict
        `player.grid` of each condition.
    """
    assets = files('coevo_manager.analysis.report') / 'assets'
    source = {name: (assets / name).read_text('utf-8') for name in ASSETS}
    data = {
        'plotly': _deflate(get_plotlyjs()),
        'charts': _deflate(
            _json({chart.name: interactive.chart_data(chart) for chart, _ in charts})
        ),
        'player': player,
    }
    sections = _sections(study, charts, pictures)
    arenas = list(study.arenas())
    title = 'Did they make progress?'
    page = Templates(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        source['report.html']
    )
    text = page.render(
        title=title if len(arenas) != 1 else f'{title} {arenas[0].capitalize()}',
        lead=_lead(study),
        colours=COLOURS,
        css=''.join(source[name] for name in ASSETS if name.endswith('.css')),
        scripts=[source[name] for name in ASSETS if name.endswith('.js')],
        data=_json(data).replace('<', '\\u003c'),
        glance=[_glance(arena, tables, charts) for arena in arenas],
        caution=statistics.caution(min(len(each.runs) for each in study.conditions)),
        warnings=_warnings(study),
        sections=sections,
        tables=[_shown(table) for table in _in_order(tables)],
        methods=METHODS,
        runs=table_view(
            'runs', tables['runs'].frame, 'Runs.', 'Every replication, and what it cost.'
        ),
        configuration=_configuration(study),
        versions=', '.join(f'{name} {metadata_version(name)}' for name in PACKAGES)
        + f'; episode kernel {study.evaluations.kernel.version}',
        footer='Measures after Simione & Nolfi (2019), Long-Term Progress and Behavior '
        'Complexification in Competitive Co-Evolution. This page needs no network.',
    )
    write_whole(path, text.encode())


def metadata_version(name: str) -> str:
    """Version of an installed distribution; "source" where it is run from its source tree."""
    try:
        return metadata.version(name.replace('_', '-'))
    except metadata.PackageNotFoundError:
        return 'source'


def table_view(identity: str, table: pd.DataFrame, title: str, caption: str) -> dict[str, Any]:
    """A table as the template takes it: text and, for numbers, the value to sort by."""
    return {
        'id': f'table-{identity}',
        'title': title,
        'caption': caption,
        'columns': [str(column).replace('_', ' ') for column in table.columns],
        'rows': [
            [_cell(value, str(column)) for column, value in zip(table.columns, row, strict=True)]
            for row in table.itertuples(index=False, name=None)
        ],
    }


def _cell(value: Any, column: str) -> dict[str, Any]:
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return {'text': '\N{EN DASH}', 'value': None}
    if isinstance(value, bool | np.bool_):
        return {'text': 'yes' if value else 'no', 'value': None}
    if isinstance(value, int | np.integer):
        grouped = f'{value:,}' if column in ('episodes', 'ticks') else str(value)
        return {'text': grouped, 'value': int(value)}
    if isinstance(value, float | np.floating):
        value = float(value)
        if column.startswith('p_') and value < 0.001:
            return {'text': '< 0.001', 'value': value}
        if value.is_integer():
            return {'text': f'{value:.0f}', 'value': float(value)}
        return {
            'text': f'{value:.3f}' if abs(value) >= 0.01 else f'{value:.2g}',
            'value': float(value),
        }
    return {'text': str(value), 'value': None}


def _lead(study: Study) -> str:
    runs = [run for each in study.conditions for run in each.runs]
    last = study.generations[-1]
    return (
        f'{len(runs)} {"run" if len(runs) == 1 else "runs"} of {len(study.conditions)} '
        f'{"condition" if len(study.conditions) == 1 else "conditions"}, compared at '
        f'{len(study.generations)} generations from 0 to {last:,}.'
    )


def _glance(
    arena: str, tables: dict[str, Table], charts: list[tuple[Chart, Path]]
) -> dict[str, Any]:
    frames = {name: tables[name].frame for name in GAMES}
    table = tables['verdicts'].frame
    table = table[table['arena'] == arena]
    names = list(dict.fromkeys(table['measure']))
    rows, answers = [], []
    for condition in dict.fromkeys(table['condition']):
        part = table[table['condition'] == condition]
        text = f'{answer(part)} {sentences(frames, arena, condition)}'
        answers.append({'condition': condition, 'text': text})
        for species in PLURAL:
            own = part[part['species'] == species]
            cells = {row.measure: _verdict_cell(row) for row in own.itertuples()}
            rows.append(
                {
                    'condition': condition,
                    'species': PLURAL[species],
                    'cells': [cells.get(name, _NOT_MEASURED) for name in names],
                }
            )
    return {
        'title': arena.capitalize(),
        'answers': answers,
        'measures': [name.capitalize() for name in names],
        'rows': rows,
        'charts': [
            _chart_view(chart, svg)
            for chart, svg in charts
            if (chart.kind, chart.arena) == (AT_A_GLANCE, arena)
        ],
    }


_NOT_MEASURED = {'style': 'unknown', 'symbol': '', 'verdict': 'no other run', 'detail': ''}


def _verdict_cell(row: Any) -> dict[str, str]:
    style, symbol = CHIPS[row.verdict]
    detail = (
        '' if np.isnan(row.difference) or row.verdict == 'no change' else f'{row.difference:+.3f}'
    )
    if detail and not np.isnan(row.bootstrap_low):
        detail += (
            f' [{row.bootstrap_low:+.3f}, {row.bootstrap_high:+.3f}], p = {row.p_paired_holm:.3g}'
        )
    return {'style': style, 'symbol': symbol, 'verdict': row.verdict, 'detail': detail}


def answer(part: pd.DataFrame) -> str:
    """Say in one sentence what the verdicts on a condition are, global progress first."""
    sentences = []
    for measure in ('global', 'historical'):
        found = part[part['measure'] == measure].set_index('species')
        verdict, gain = found['verdict'], found['difference']
        if gain.isna().all():
            return 'Too few generations to compare: at least 0 and two later ones are needed.'
        if (verdict == 'cannot be claimed').any():
            gains = ', '.join(f'{PLURAL[s]} {gain[s]:+.3f}' for s in PLURAL)
            sentences.append(f'{measure} gain of fitness {gains}')
            continue
        winners = [PLURAL[s] for s in PLURAL if verdict[s] == 'progress']
        cyclic = [PLURAL[s] for s in PLURAL if verdict[s] == 'cyclic']
        losers = [PLURAL[s] for s in PLURAL if verdict[s] == 'retrogression']
        same = [PLURAL[s] for s in PLURAL if verdict[s] == 'no change']
        text = (
            f'{measure} progress of {" and ".join(winners)}'
            if winners
            else f'no significant {measure} progress'
        )
        if cyclic:
            text += f', a gain of {" and ".join(cyclic)} within a cycle'
        if same:
            text += f', no change of {" and ".join(same)}'
        if losers:
            text += f', retrogression of {" and ".join(losers)}'
        sentences.append(text)
    text = '; '.join(sentences)
    if (part['verdict'] == 'cannot be claimed').any():
        return f'One replication claims nothing; it shows a {text}.'
    return f'{text[0].upper()}{text[1:]}.'


def _warnings(study: Study) -> list[str]:
    found = []
    for each in study.conditions:
        wrong = [
            run.name for run, same in zip(each.runs, each.reproduced, strict=True) if same is False
        ]
        if wrong:
            found.append(
                f'{", ".join(wrong)}: this version of the episode kernel does not reproduce the '
                'fitness that the run stored; its tournament is of the same genomes in a '
                'different simulation.'
            )
        for run in each.runs:
            for species in run.never_evolved:
                found.append(
                    f'{run.name}: the {PLURAL[species]} never evolved, the run ended before '
                    f'their turn; what it says of {PLURAL[species]} is of random genomes.'
                )
    return found


def _sections(
    study: Study, charts: list[tuple[Chart, Path]], pictures: list[Picture]
) -> list[dict[str, Any]]:
    sections = []
    for arena in study.arenas():
        own = [
            _chart_view(chart, svg)
            for chart, svg in charts
            if chart.arena == arena and chart.kind != AT_A_GLANCE
        ]
        drawn = [_picture_view(picture) for picture in pictures if picture.arena == arena]
        sections.append(
            {'id': slug(arena), 'title': f'Figures, {arena}', 'charts': [*own, *drawn]}
        )
    between = [_chart_view(chart, svg) for chart, svg in charts if chart.arena is None]
    if between:
        sections.append(
            {'id': 'obstacle', 'title': 'Does the obstacle matter?', 'charts': between}
        )
    return sections


def _chart_view(chart: Chart, svg: Path) -> dict[str, Any]:
    caption = f'{chart.caption} {chart.note}'.strip()
    return _figure(chart.name, chart.title, caption, svg) | {'interactive': True}


def _picture_view(picture: Picture) -> dict[str, Any]:
    return _figure(picture.name, picture.title, picture.caption, picture.svg)


def _figure(name: str, title: str, caption: str, svg: Path) -> dict[str, Any]:
    return {
        'name': name,
        'title': title,
        'caption': caption,
        'image': _deflate(svg.read_text('utf-8')),
        'interactive': False,
    }


def _in_order(tables: dict[str, Table]) -> list[Table]:
    """Those that are shown, in the order of `methods.TABLES`."""
    return [table for kind in TABLES for table in tables.values() if table.kind == kind]


def _shown(table: Table) -> dict[str, Any]:
    title, caption = TABLES[table.kind]
    where = f' {table.arena.capitalize()}.' if table.arena else ''
    test = {'paper': " The paper's tests.", 'paired_holm': ' Paired tests, corrected.'}
    return table_view(
        table.name, table.frame, title + where, caption + test.get(table.test or '', '')
    )


def _configuration(study: Study) -> dict[str, Any]:
    """Configuration of the first run of each condition, values that agree in one cell."""
    values = {
        f'{each.condition.name}, {each.condition.arena}': each.runs[0].configuration.as_dict()
        for each in study.conditions
    }
    rows = []
    for name, option in all_fields().items():
        found = {label: str(own[name]) for label, own in values.items() if name in own}
        if name == 'seed' or not found:
            continue
        if len(set(found.values())) == 1:
            text = next(iter(found.values()))
        else:
            text = '; '.join(f'{label}: {value}' for label, value in found.items())
        rows.append((name, text, option.unit, option.help))
    table = pd.DataFrame(rows, columns=['field', 'value', 'unit', 'meaning'])
    return table_view('configuration', table, 'Configuration.', 'Of every condition.')


def _json(data: Any) -> str:
    return json.dumps(data, separators=(',', ':'), allow_nan=False)


def _deflate(text: str) -> str:
    packer = zlib.compressobj(9, wbits=-15)
    return base64.b64encode(packer.compress(text.encode()) + packer.flush()).decode()

"""report.html: the answer, figures, an episode player, tables and provenance on one page."""

import base64
import json
import zlib
from importlib import metadata
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd
from jinja2 import Environment as Templates
from plotly.offline import get_plotlyjs

from coevo_manager.analysis.figures import interactive
from coevo_manager.analysis.figures.charts import Chart
from coevo_manager.analysis.figures.marks import slug_of
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.report.methods import METHODS, TABLES
from coevo_manager.analysis.study import Study
from coevo_manager.core.configuration import FIELDS
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.core.species import PLURAL

PACKAGES = ('coevo_manager', 'numpy', 'numba', 'scipy', 'statsmodels', 'matplotlib', 'plotly')
CHIPS = {
    'progress': ('progress', '▲'),
    'cyclic': ('none', '\N{CLOCKWISE OPEN CIRCLE ARROW}'),
    'retrogression': ('retrogression', '▼'),
    'not significant': ('none', '\N{EN DASH}'),
    'cannot be claimed': ('unknown', '?'),
}


def write_report(
    path: Path,
    study: Study,
    charts: list[tuple[Chart, Path]],
    pictures: list[dict],
    tables: dict[str, pd.DataFrame],
    player: list[dict],
) -> None:
    """Write the page.

    Parameters
    ----------
    charts : list of (Chart, Path)
        Each chart with its SVG.
    pictures : list of dict
        Figures that are only drawn for print: `name`, `title`, `caption`, `svg` (Path), `arena`.
    tables : dict
        Tables by name, of which those in `methods.TABLES` are shown.
    player : list of dict
        `player.grid` of each condition.
    """
    assets = files('coevo_manager.analysis.report') / 'assets'
    source = {name: (assets / name).read_text('utf-8') for name in
              ('report.html', 'report.css', 'report.js', 'player.js')}  # fmt: skip
    data = {
        'plotly': _deflate(get_plotlyjs()),
        'charts': {chart.name: interactive.figure(chart) for chart, _ in charts},
        'player': player,
    }
    by_name = {
        chart.name: _figure(chart.name, chart.title, chart.caption, svg, True)
        for chart, svg in charts
    }
    verdicts = tables['verdicts']
    page = Templates(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        source['report.html']
    ).render(
        title='Did they make progress?' if len(study.arenas()) != 1 else
        f'Did they make progress? {next(iter(study.arenas())).capitalize()}',
        lead=_lead(study),
        css=source['report.css'],
        js=source['report.js'],
        player_js=source['player.js'],
        data=json.dumps(data, separators=(',', ':'), allow_nan=False).replace('<', '\\u003c'),
        glance=[_glance(study, arena, verdicts, by_name) for arena in study.arenas()],
        caution=statistics.caution(min(len(each.runs) for each in study.conditions)),
        warnings=_warnings(study),
        sections=_sections(study, by_name, pictures),
        tables=[
            table_view(name, tables[name], title, caption)
            for name, (title, caption) in _table_titles(tables).items()
        ],
        methods=METHODS,
        runs=table_view('runs', tables['runs'], 'Runs.', 'Every replication, and what it cost.'),
        configuration=_configuration(study),
        versions=', '.join(f'{name} {metadata_version(name)}' for name in PACKAGES)
        + f'; episode kernel {study.evaluations.kernel.version}',
        footer='Measures after Simione & Nolfi (2019), Long-Term Progress and Behavior '
        'Complexification in Competitive Co-Evolution. This page needs no network.',
    )  # fmt: skip
    write_whole(path, page.encode())


def metadata_version(name: str) -> str:
    """Version of an installed distribution; "source" where it is run from its source tree."""
    try:
        return metadata.version(name.replace('_', '-'))
    except metadata.PackageNotFoundError:
        return 'source'


def table_view(identity: str, table: pd.DataFrame, title: str, caption: str) -> dict:
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


def _cell(value, column: str) -> dict:
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return {'text': '\N{EN DASH}', 'value': None}
    if isinstance(value, bool | np.bool_):
        return {'text': 'yes' if value else 'no', 'value': None}
    if isinstance(value, int | np.integer):
        grouped = f'{value:,}' if column in ('episodes', 'ticks') else str(value)
        return {'text': grouped, 'value': int(value)}
    if isinstance(value, float | np.floating):
        if column.startswith('p_') and value < 0.001:
            return {'text': '< 0.001', 'value': float(value)}
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


def _glance(study: Study, arena: str, verdicts: pd.DataFrame, figures: dict) -> dict:
    table = verdicts[verdicts['arena'] == arena]
    names = list(dict.fromkeys(table['measure']))
    rows, answers = [], []
    for condition in dict.fromkeys(table['condition']):
        part = table[table['condition'] == condition]
        answers.append({'condition': condition, 'text': answer(part)})
        for species in PLURAL:
            cells = {row.measure: _verdict_cell(row) for row in
                     part[part['species'] == species].itertuples()}  # fmt: skip
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
        'chart': figures[f'gains_{slug_of(arena)}'],
    }


_NOT_MEASURED = {'style': 'unknown', 'symbol': '', 'verdict': 'no other run', 'detail': ''}


def _verdict_cell(row) -> dict:
    style, symbol = CHIPS[row.verdict]
    detail = '' if np.isnan(row.difference) else f'{row.difference:+.3f}'
    if not np.isnan(row.bootstrap_low):
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
        text = (
            f'{measure} progress of {" and ".join(winners)}'
            if winners
            else f'no significant {measure} progress'
        )
        if cyclic:
            text += f', a gain of {" and ".join(cyclic)} within a cycle'
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
            run.name for run, same in zip(each.runs, each.reproduced, strict=True) if not same
        ]
        if wrong:
            found.append(
                f'{", ".join(wrong)}: this version of the episode kernel does not reproduce the '
                'fitness '
                'that the run stored; its tournament is of the same genomes in a different '
                'simulation.'
            )
    return found


def _sections(study: Study, by_name: dict, pictures: list[dict]) -> list[dict]:
    sections = []
    for arena in study.arenas():
        slug = slug_of(arena)
        own = [
            item
            for name, item in by_name.items()
            if name.endswith(f'_{slug}') and 'gains' not in name
        ]
        drawn = [
            _figure(item['name'], item['title'], item['caption'], item['svg'], False)
            for item in pictures
            if item['arena'] == arena
        ]
        sections.append({'id': slug, 'title': f'Figures, {arena}', 'charts': own + drawn})
    both = [item for name, item in by_name.items() if name.startswith('obstacle_comparison')]
    if both:
        sections.append({'id': 'obstacle', 'title': 'Does the obstacle matter?', 'charts': both})
    return sections


def _figure(name: str, title: str, caption: str, svg: Path, is_interactive: bool) -> dict:
    return {
        'name': name,
        'title': title,
        'caption': caption,
        'image': _deflate(svg.read_text('utf-8')),
        'interactive': is_interactive,
    }


def _table_titles(tables: dict[str, pd.DataFrame]) -> dict[str, tuple[str, str]]:
    """Titles and captions of the tables to show, by name; those of an environment begin alike."""
    return {
        name: text
        for prefix, text in TABLES.items()
        for name in tables
        if name == prefix or (prefix.startswith('table') and name.startswith(prefix))
    }


def _configuration(study: Study) -> dict:
    """Configuration of the first run of each condition, values that agree in one cell."""
    values = {
        f'{each.condition.name}, {each.condition.arena}': each.runs[0].configuration.as_dict()
        for each in study.conditions
    }
    rows = []
    for name, option in FIELDS.items():
        if name == 'seed':
            continue
        found = {label: str(configuration[name]) for label, configuration in values.items()}
        if len(set(found.values())) == 1:
            text = next(iter(found.values()))
        else:
            text = '; '.join(f'{label}: {value}' for label, value in found.items())
        rows.append((name, text, option.unit, option.help))
    table = pd.DataFrame(rows, columns=['field', 'value', 'unit', 'meaning'])
    return table_view('configuration', table, 'Configuration.', 'Of every condition.')


def _deflate(text: str) -> str:
    packer = zlib.compressobj(9, wbits=-15)
    return base64.b64encode(packer.compress(text.encode()) + packer.flush()).decode()

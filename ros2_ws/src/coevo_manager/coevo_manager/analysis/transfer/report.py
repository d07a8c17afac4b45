"""The transfer of champions as a table to read and a figure."""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from coevo_manager.analysis.figures.charts import CONDITION_COLOURS, CONDITION_MARKERS
from coevo_manager.analysis.figures.draw import MARKS, STYLE
from coevo_manager.analysis.transfer.measure import KERNEL, hurt, perturbed_alone
from coevo_manager.core.species import SPECIES

_HEAD = (
    '| condition | predators alone | prey alone | predator fitness | prey fitness '
    '| rank, predators | rank, prey | hurts |\n'
    '|---|--:|--:|--:|--:|--:|--:|---|'
)


def to_markdown(table: pd.DataFrame, count: int, draws: int) -> str:
    """Return `measure_transfer`'s table as Markdown, one table a run."""
    parts = [
        '# Transfer',
        f'{count} champions of each species and run meet the champions of all runs. Fitness is '
        f'the mean over opponents and, where anything is random, over {draws} draws. Changes are '
        'from the kernel with perfect robots. "Predators alone" is the change of the fitness of '
        'predators when only predators are perturbed, and "prey alone" that of prey when only '
        'prey are. In the next columns both are perturbed: fitness, and its Spearman rank '
        'correlation over champions with that in the kernel. "Hurts" names the species whose 95 % '
        'interval lies below 0 when it alone is perturbed.',
    ]
    harmed = hurt(table)
    for run, rows in table.groupby('run', sort=False):
        lines = [_HEAD]
        for condition, group in rows.groupby('condition', sort=False):
            alone = [_alone(group, species) for species in SPECIES]
            both = group[group.perturbed == 'both'].set_index('species')
            cells = [f'{both.fitness[species]:.3f}' for species in SPECIES]
            if condition == KERNEL:
                cells += ['', '', '']
            else:
                cells += [_number(both.rank_correlation[species]) for species in SPECIES]
                cells.append(harmed.get((run, condition), ''))
            lines.append(f'| {" | ".join([condition, *alone, *cells])} |')
        parts += [f'## {run}', '\n'.join(lines)]
    return '\n\n'.join(parts) + '\n'


def _alone(group: pd.DataFrame, species: str) -> str:
    own = group[(group.perturbed == species) & (group.species == species)]
    return f'{own.change.iloc[0]:+.3f}' if len(own) else ''


def _number(value: float) -> str:
    return 'n/a' if np.isnan(value) else f'{value:.2f}'


def draw_transfer(table: pd.DataFrame) -> Figure:
    """Draw, by condition, what perturbing each species costs it, and how ranks persist."""
    names = [name for name in table.condition.unique() if name != KERNEL]
    runs = table.run.unique()
    places = np.arange(len(names))[::-1]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 0.24 * len(names) + 1.3), layout='constrained')
        axes = figure.subplots(1, 4, sharey=True)
        for k, run in enumerate(runs):
            look = {
                'color': CONDITION_COLOURS[k % len(CONDITION_COLOURS)],
                'marker': MARKS[CONDITION_MARKERS[k % len(CONDITION_MARKERS)]],
                'markersize': 3.5,
                'linestyle': 'none',
            }
            offset = (0.5 - (k + 0.5) / len(runs)) * 0.6
            for j, species in enumerate(SPECIES):
                rows = table[(table.run == run) & (table.species == species)]
                own = perturbed_alone(rows).set_index('condition').loc[names]
                both = rows[rows.perturbed == 'both'].set_index('condition').loc[names]
                spans = [own.change - own.low, own.high - own.change]
                (first, *_) = axes[j].errorbar(
                    own.change, places + offset, xerr=spans, elinewidth=0.8, **look
                )
                axes[2 + j].plot(both.rank_correlation, places + offset, **look)
            first.set_label(run)
        for j, species in enumerate(SPECIES):
            axes[j].axvline(0, color='#888888', linewidth=0.8, zorder=1)
            axes[j].set(xlabel=f'change of {species} fitness')
            axes[j].set_title(f'{species} perturbed', loc='left')
            axes[2 + j].set(xlabel="Spearman's rho", xlim=(-1.05, 1.05))
            axes[2 + j].set_title(f'ranks of {species}', loc='left')
        axes[0].set_yticks(places, names)
        if len(runs) > 1:
            figure.legend(
                *axes[1].get_legend_handles_labels(), loc='outside lower center', ncols=3
            )
    return figure

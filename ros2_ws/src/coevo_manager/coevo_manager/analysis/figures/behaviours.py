"""Fig. 5: representative behaviours, from the simplest to the most complex."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

from coevo_manager.analysis.figures.draw import STYLE
from coevo_manager.analysis.measures.paper import representative
from coevo_manager.analysis.play.tournament import Evaluations
from coevo_manager.analysis.study import ConditionResults, tournament_block
from coevo_manager.core.episodes.trace import Trace
from coevo_manager.core.species import COLOURS, PLURAL, SPECIES
from marxbot_sim.core.parameters import BODY_RADIUS, OBSTACLE_RADIUS, TICK, Arena

TITLES = ('simplest', 'simple', 'median', 'complex', 'most complex')
CAPTION = (
    'These are episodes of the last generation of the first replication (Fig. 5). They lie at '
    "the 0th, 25th, 50th, 75th and 100th percentile of the predator's (A) and of the prey's (B) "
    'complexity. A light disc is a start, a dark disc an end. Below each episode are its '
    'translational and rotational wheel speed over time. The numbers are the complexity c of '
    'predator and prey, in rad/s per tick.'
)
DASHES: dict[str, Any] = {'predator': '-', 'prey': (0, (3, 1.2))}


def behaviours(each: ConditionResults, evaluations: Evaluations) -> Figure:
    """Draw the five representative episodes by the complexity of each species."""
    run, last = each.runs[0], each.snapshots[0][-1]
    complexity = evaluations[tournament_block(run, last, last)].complexity
    assert complexity is not None
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 6.0), layout='constrained')
        top, bottom, foot = figure.subfigures(3, 1, squeeze=False, height_ratios=[1, 1, 0.08])[
            :, 0
        ]
        for part, species, letter in zip((top, bottom), SPECIES, 'AB', strict=True):
            part.suptitle(
                f'{letter}  By the complexity of the {species}',
                x=0.01,
                ha='left',
                fontsize=8.5,
                weight='bold',
            )
            axes = part.subplots(3, 5, height_ratios=[4, 1, 1])
            pairs = representative(complexity[..., SPECIES.index(species)])
            i, j = np.transpose(pairs)
            traces = evaluations.kernel.traces(last.predators, last.prey, i, j, run.environment)
            for column, (pair, trace) in enumerate(zip(pairs, traces, strict=True)):
                _arena(axes[0, column], trace, run.environment.arena)
                c = complexity[pair]
                axes[0, column].set_title(
                    f'{TITLES[column]}\nc = {c[0]:.2f} | {c[1]:.2f}', fontsize=7, weight='normal'
                )
                _speeds(axes[1:, column], trace, run.environment.episode_ticks, first=column == 0)
        foot.legend(
            [Line2D([], [], color=COLOURS[s], linestyle=DASHES[s]) for s in SPECIES],
            [f'{PLURAL[s].capitalize()} (c {side} of the bar)'
             for s, side in zip(SPECIES, ('left', 'right'), strict=True)],
            loc='center',
            ncols=2,
        )  # fmt: skip
    return figure


def _arena(axes: Axes, trace: Trace, arena: Arena) -> None:
    half = arena.size / 2
    axes.add_patch(Rectangle((-half, -half), arena.size, arena.size, fill=False, linewidth=1))
    if arena.obstacle:
        axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS, color='#555555'))
    for robot, species in enumerate(SPECIES):
        path = trace.poses[:, robot, :2]
        axes.plot(*path.T, color=COLOURS[species], linestyle=DASHES[species], linewidth=0.7)
        for place, alpha in ((path[0], 0.3), (path[-1], 1.0)):
            axes.add_patch(
                Circle(tuple(place), BODY_RADIUS, color=COLOURS[species], alpha=alpha, linewidth=0)
            )
    margin = half * 1.03
    axes.set(xlim=(-margin, margin), ylim=(-margin, margin), aspect='equal')
    axes.axis('off')


def _speeds(axes: np.ndarray, trace: Trace, longest: int, first: bool) -> None:
    """Draw both wheel speeds over the time that an episode may last."""
    time = np.arange(1, trace.ticks + 1) * TICK
    for robot, species in enumerate(SPECIES):
        left, right = trace.wheels[:, robot].T
        for axis, speed in zip(axes, ((left + right) / 2, (right - left) / 2), strict=True):
            axis.plot(
                time, speed, color=COLOURS[species], linestyle=DASHES[species], linewidth=0.5,
                rasterized=True,
            )  # fmt: skip
    for axis, name in zip(axes, ('transl.', 'rotat.'), strict=True):
        axis.set_ylim(-10.5, 10.5)
        axis.set_xlim(0, longest * TICK)
        axis.set_yticks([-10, 0, 10], ['-10', '0', '10'] if first else [])
        axis.set_ylabel(f'{name}\n(rad/s)' if first else '', fontsize=6.5)
        axis.tick_params(labelsize=6, length=2)
    axes[0].set_xticklabels([])
    axes[1].set_xlabel('time (s)', fontsize=7)

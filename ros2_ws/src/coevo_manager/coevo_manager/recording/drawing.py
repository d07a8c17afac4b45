"""Episodes as pictures: trajectories as PNG, the chase as an animated GIF."""

from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from coevo_manager.core.species import COLOURS
from marxbot_sim.core.parameters import BODY_RADIUS, OBSTACLE_RADIUS, TICK

matplotlib.use('Agg')

FRAMES_PER_SECOND = 10
TRAIL = 50
"""Ticks of the trail in an animation."""


@dataclass(frozen=True)
class Track:
    """An episode as it is drawn.

    Attributes
    ----------
    poses : float array, shape (t + 1, 2, 3)
        x and y in m and heading in rad of predator and prey.
    size : float
        Side of the arena, m.
    obstacle, captured : bool
    """

    poses: np.ndarray
    size: float
    obstacle: bool
    captured: bool

    @classmethod
    def from_quaternions(cls, robots, size, obstacle, captured):
        """Make a track of each robot's (x, y, qz, qw)."""
        length = min(map(len, robots))
        poses = np.array([robot[:length] for robot in robots]).transpose(1, 0, 2)
        heading = 2 * np.arctan2(poses[..., 2], poses[..., 3])
        return cls(np.dstack([poses[..., :2], heading]), size, obstacle, captured)

    @property
    def title(self):
        """What happened, in a line."""
        seconds = (len(self.poses) - 1) * TICK
        return (
            f'prey captured after {seconds:.1f} s'
            if self.captured
            else f'prey got away for {seconds:.1f} s'
        )


def _arena(track):
    figure = Figure(figsize=(5, 5.3), dpi=110, layout='constrained')
    axes = figure.add_subplot()
    half = track.size / 2
    axes.add_patch(
        Rectangle(
            (-half, -half), track.size, track.size, facecolor='#f4f4f4', edgecolor='black', lw=3
        )
    )
    if track.obstacle:
        axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS, color='black'))
    axes.set(
        xlim=(-half * 1.03, half * 1.03),
        ylim=(-half * 1.03, half * 1.03),
        xlabel='x (m)',
        ylabel='y (m)',
    )
    axes.set_aspect('equal')
    return figure, axes


def _robot(axes, pose, color):
    x, y, heading = pose
    body = axes.add_patch(
        Circle((x, y), BODY_RADIUS, facecolor=color, edgecolor='black', lw=0.8, zorder=3)
    )
    (nose,) = axes.plot(*_nose(x, y, heading), color='black', lw=1.5, zorder=4)
    return body, nose


def _nose(x, y, heading):
    return [x, x + BODY_RADIUS * np.cos(heading)], [y, y + BODY_RADIUS * np.sin(heading)]


def draw_trajectories(track, path):
    """Write the paths of both robots, with their starts (hollow) and ends, to a PNG."""
    figure, axes = _arena(track)
    for robot, (name, color) in enumerate(COLOURS.items()):
        poses = track.poses[:, robot]
        axes.plot(poses[:, 0], poses[:, 1], color=color, lw=1, label=name)
        axes.add_patch(Circle(poses[0, :2], BODY_RADIUS, fill=False, edgecolor=color, ls='--'))
        _robot(axes, poses[-1], color)
    axes.set_title(track.title)
    figure.legend(loc='outside lower center', ncols=2, frameon=False)
    figure.savefig(path, format='png')


def draw_animation(track, path, rate=1.0):
    """Write an animated GIF that runs at `rate` times real time."""
    figure, axes = _arena(track)
    robots, trails = [], []
    for robot, color in enumerate(COLOURS.values()):
        robots.append(_robot(axes, track.poses[0, robot], color))
        trails.append(axes.plot([], [], color=color, lw=1.5)[0])
    step = max(1, round(rate / (TICK * FRAMES_PER_SECOND)))
    ticks = [*range(0, len(track.poses) - 1, step), len(track.poses) - 1]
    title = axes.set_title('')

    def draw(tick):
        title.set_text(track.title if tick == ticks[-1] else f'{tick * TICK:.1f} s')
        for robot, ((body, nose), trail) in enumerate(zip(robots, trails, strict=True)):
            x, y, heading = track.poses[tick, robot]
            body.center = x, y
            nose.set_data(*_nose(x, y, heading))
            trail.set_data(*track.poses[max(0, tick - TRAIL) : tick + 1, robot, :2].T)

    pace = min(FRAMES_PER_SECOND, rate / (TICK * step))
    animation = FuncAnimation(figure, draw, frames=ticks, repeat=False)
    animation.save(path, writer=PillowWriter(fps=pace))

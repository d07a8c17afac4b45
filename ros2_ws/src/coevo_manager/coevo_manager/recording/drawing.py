"""Episodes as pictures: the arena, the robots, their trajectories."""

import io
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

from coevo_manager.core.species import COLOURS
from marxbot_sim.core.parameters import BODY_RADIUS, OBSTACLE_RADIUS, TICK


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


def draw_arena(size, obstacle):
    """Return a figure and its axes with all that does not move, the legend included."""
    figure = Figure(figsize=(5, 5.4), dpi=110, layout='constrained')
    axes = figure.add_subplot()
    half = size / 2
    axes.add_patch(
        Rectangle((-half, -half), size, size, facecolor='#f4f4f4', edgecolor='black', lw=3)
    )
    if obstacle:
        axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS, color='black'))
    axes.set(
        xlim=(-half * 1.03, half * 1.03),
        ylim=(-half * 1.03, half * 1.03),
        xlabel='x (m)',
        ylabel='y (m)',
        title=' ',
    )
    axes.set_aspect('equal')
    handles = [
        Line2D([], [], color=color, marker='o', ms=9, mec='black', label=species)
        for species, color in COLOURS.items()
    ]
    figure.legend(handles=handles, loc='outside lower center', ncols=2, frameon=False)
    return figure, axes


class RobotArtists:
    """A robot in a drawing: its body, and a line from its centre forward."""

    def __init__(self, axes, color):
        self._body = axes.add_patch(
            Circle((0, 0), BODY_RADIUS, facecolor=color, edgecolor='black', lw=0.8, zorder=3)
        )
        (self._nose,) = axes.plot([], [], color='black', lw=1.5, zorder=4)

    @property
    def artists(self):
        """What is drawn, the lowest first."""
        return self._body, self._nose

    def move(self, pose):
        """Put it at x, y, heading."""
        x, y, heading = pose
        self._body.center = x, y
        self._nose.set_data(
            [x, x + BODY_RADIUS * np.cos(heading)], [y, y + BODY_RADIUS * np.sin(heading)]
        )


def trajectories(track):
    """Return a figure of both robots' paths, with their starts (hollow) and ends."""
    figure, axes = draw_arena(track.size, track.obstacle)
    for robot, color in enumerate(COLOURS.values()):
        poses = track.poses[:, robot]
        axes.plot(poses[:, 0], poses[:, 1], color=color, lw=1)
        axes.add_patch(Circle(poses[0, :2], BODY_RADIUS, fill=False, edgecolor=color, ls='--'))
        RobotArtists(axes, color).move(poses[-1])
    axes.set_title(track.title)
    return figure


def draw_trajectories(track):
    """Return a PNG (bytes) of the `trajectories`."""
    content = io.BytesIO()
    trajectories(track).savefig(content, format='png')
    return content.getvalue()

"""What scripts/physics measures and draws; see there."""

import argparse
import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from coevo_manager.analysis.figures.draw import STYLE
from marxbot_sim.core.layout import CONTACT
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    OBSTACLE_RADIUS,
    TICK,
    WHEEL_RADIUS,
    Arena,
)
from marxbot_sim.core.physics import PHYSICS, make_world

COLOURS = {'kinematic': '#000000', 'pymunk': '#e69f00'}
FULL = 10.0
FACING = 5.0  # degrees
AWAY = (-1.2, -1.2, 0.0)


def commands(rng, ticks, change):
    """Return wheel speeds of two robots, rad/s, that change by at most `change` in a tick."""
    wheels = np.zeros((ticks + 1, 2, 2))
    for tick in range(ticks):
        step = rng.uniform(-FULL, FULL, (2, 2)) - wheels[tick]
        wheels[tick + 1] = wheels[tick] + np.clip(step, -change, change)
    return wheels[1:]


def drive(physics, arena, start, wheels):
    """Return poses after each tick, contacts, and contact forces where there are any."""
    world = make_world(physics, arena)
    world.reset(start)
    poses, contacts, forces = [world.poses], [], []
    for speeds in wheels:
        world.step(speeds)
        poses.append(world.poses)
        contacts.append(world.bodies[:, CONTACT])
        forces.append(world.contact_forces if physics == 'pymunk' else [0, 0])
    return np.array(poses), np.array(contacts), np.array(forces)


def free_motion():
    """Print how far the two physics part in free motion, by how fast wheel speeds change."""
    arena, start = Arena(size=300.0), ((-50.0, 0.0, 0.0), (50.0, 0.0, 0.0))
    print('| change a tick, rad/s | position after 100 s, mm | farthest, mm | heading, degrees |')
    print('|--:|--:|--:|--:|')
    for change in (0.5, 1, 2, 5, 20):
        ends, most, turns = [], [], []
        for seed in range(10):
            wheels = commands(np.random.default_rng(seed), 1000, change)
            ours, theirs = (drive(physics, arena, start, wheels)[0] for physics in PHYSICS)
            apart = np.hypot(*(ours - theirs)[..., :2].transpose(2, 0, 1))
            turn = (ours - theirs)[..., 2]
            ends.append(apart[-1].mean())
            most.append(apart.max())
            turns.append(np.abs((turn + math.pi) % (2 * math.pi) - math.pi).max())
        values = 1000 * np.median(ends), 1000 * np.median(most), math.degrees(np.median(turns))
        print(f'| {change:g} | {values[0]:.1f} | {values[1]:.1f} | {values[2]:.1f} |')


def press(physics, degrees, seconds=4.0):
    """Return how a robot turns and slides that drives into a wall, from the hit on.

    It drives at full speed, that many degrees off the wall's normal.

    Returns
    -------
    headings, slides : arrays
        Off the normal, degrees, and along the wall, m, after each tick.
    """
    start = ((1.5 - BODY_RADIUS - 0.02, 0.0, math.radians(degrees)), AWAY)
    wheels = np.repeat([[[FULL, FULL], [0, 0]]], round(seconds / TICK), axis=0)
    poses, contacts, _ = drive(physics, Arena(), start, wheels)
    hit = np.argmax(contacts[:, 0] > 0)
    after = poses[hit:, 0]
    return np.degrees(after[:, 2]), after[:, 1] - after[0, 1]


def facing():
    """Print how long a robot that drives into a wall takes to face it, within 5 degrees."""
    print('| off the normal | seconds, kernel | pymunk | slide in mm, kernel | pymunk |')
    print('|--:|--:|--:|--:|--:|')
    for degrees in range(10, 90, 10):
        times, slides = [], []
        for physics in PHYSICS:
            headings, slid = press(physics, degrees)
            faces = np.argmax(np.abs(headings) < FACING)
            times.append(faces * TICK)
            slides.append(1000 * slid[faces])
        print(
            f'| {degrees}° | {times[0]:.1f} | {times[1]:.1f} | {slides[0]:.0f} | {slides[1]:.0f} |'
        )


def draw(path):
    """Draw where the two physics differ."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 8.4), layout='constrained')
        axes = figure.subplots(3, 2)
        _draw_start(axes[0, 0])
        _draw_free(axes[0, 1])
        _draw_wall(axes[1, 0])
        _draw_obstacle(axes[1, 1])
        _draw_headings(axes[2, 0])
        _draw_times(axes[2, 1])
        handles = [mpl.lines.Line2D([], [], color=colour) for colour in COLOURS.values()]
        figure.legend(handles, COLOURS, loc='outside lower center', ncols=2)
        figure.savefig(path, dpi=150)


def _draw_start(axes):
    wheels = np.repeat([[[FULL, FULL], [0, 0]], [[0, 0], [0, 0]]], 4, axis=0)
    for physics, colour in COLOURS.items():
        poses = drive(physics, Arena(), ((-0.5, 0, 0), AWAY), wheels)[0]
        way = poses[:, 0, 0] + 0.5
        axes.plot(np.arange(9) * TICK, 100 * way, color=colour, marker='.')
    axes.set(xlabel='time, s', ylabel='way, cm')
    axes.set_title('full speed for 0.4 s, then stop', loc='left')


def _draw_free(axes):
    wheels = commands(np.random.default_rng(1), 300, 20)
    for physics, colour in COLOURS.items():
        poses = drive(physics, Arena(size=300.0), ((0, 0, 0), (9, 9, 0)), wheels)[0]
        axes.plot(*poses[:, 0, :2].T, color=colour, linewidth=0.8)
    axes.set(xlabel='x, m', ylabel='y, m', aspect='equal')
    axes.set_title('random speeds, new each tick', loc='left')


def _draw_wall(axes):
    wheels = np.repeat([[[FULL, FULL], [0, 0]]], 22, axis=0)
    for angle in (15, 30, 45, 60):
        start = ((-1.2, 1.5 - BODY_RADIUS - 0.05, math.radians(angle)), AWAY)
        for physics, colour in COLOURS.items():
            poses = drive(physics, Arena(), start, wheels)[0][:, 0]
            offset = 0.13 * angle / 15
            axes.plot(poses[:, 0], poses[:, 1] - offset, color=colour)
            x, y, heading = poses[-1]
            tip = x + 0.08 * math.cos(heading), y - offset + 0.08 * math.sin(heading)
            axes.plot(*zip((x, y - offset), tip, strict=True), color=colour, linewidth=2.5)
        axes.text(-1.24, start[0][1] - offset, f'{angle}°', ha='right', va='center', fontsize=7)
    axes.set(xlabel='x, m', yticks=[], xlim=(-1.4, -0.5))
    axes.set_title('into a wall at an angle, 2.2 s (bold: heading)', loc='left')


def _draw_headings(axes):
    for degrees in (20, 40, 60, 80):
        for physics, colour in COLOURS.items():
            headings, _ = press(physics, degrees, 2.5)
            axes.plot(np.arange(len(headings)) * TICK, headings, color=colour)
    axes.set(xlabel='time from the hit on, s', ylabel='off the normal, degrees', xlim=(0, 1.8))
    axes.set_title('a robot that presses turns to face the wall', loc='left')


def _draw_times(axes):
    angles = np.arange(5, 90, 5)
    for physics, colour in COLOURS.items():
        times = [TICK * np.argmax(np.abs(press(physics, a)[0]) < FACING) for a in angles]
        axes.plot(angles, times, color=colour, marker='.')
    axes.set(xlabel='off the normal at the hit, degrees', ylabel='time, s')
    axes.set_title(f'time until it faces the wall within {FACING:g}°', loc='left')


def _draw_obstacle(axes):
    wheels = np.repeat([[[FULL, FULL], [0, 0]]], 30, axis=0)
    axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS, color='#888888'))
    axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS + BODY_RADIUS, fill=False, linestyle=':'))
    for y in (-0.12, -0.06, 0.02, 0.08, 0.13):
        for physics, colour in COLOURS.items():
            poses = drive(physics, Arena(obstacle=True), ((-0.4, y, 0), AWAY), wheels)[0]
            axes.plot(*poses[:, 0, :2].T, color=colour)
    axes.set(xlabel='x, m', ylabel='y, m', aspect='equal')
    axes.set_title('paths past the obstacle, 3 s', loc='left')


def contact():
    """Print forces, overlaps and agreement of the contact sensor of random driving."""
    rng = np.random.default_rng(0)
    most, deepest, felt = [], [], []
    for seed in range(20):
        wheels = np.repeat(rng.uniform(-3, FULL, (100, 2, 2)), 10, axis=0)
        world = make_world('pymunk', Arena(obstacle=True))
        start = ((-0.7, rng.uniform(-1, 1), seed), (0.7, rng.uniform(-1, 1), seed))
        world.reset(start)
        for speeds in wheels:
            world.step(speeds)
            places = world._arenas._state[:, :2]  # the world itself reports no overlap
            most.append(world.contact_forces)
            felt.append(world.bodies[:, CONTACT])
            walls = np.abs(places).max() - 1.5 + BODY_RADIUS
            post = OBSTACLE_RADIUS + BODY_RADIUS - np.hypot(*places.T).min()
            deepest.append(max(walls, post))
    most, felt = np.array(most), np.array(felt) > 0
    print(
        f'contact in {100 * felt.mean():.0f} % of ticks, mean force then '
        f'{most[felt].mean():.1f} N, highest {most.max():.1f} N; '
        f'greatest overlap {1000 * max(deepest):.2f} mm'
    )


def main():
    """Measure, print and draw."""
    parser = argparse.ArgumentParser(prog='physics', add_help=False)
    parser.add_argument('figure', type=Path, nargs='?')
    options = parser.parse_args()
    speed = FULL * WHEEL_RADIUS
    print(f'full speed {speed:.2f} m/s')
    free_motion()
    facing()
    contact()
    if options.figure:
        draw(options.figure)


if __name__ == '__main__':
    main()

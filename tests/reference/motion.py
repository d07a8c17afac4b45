"""How the robots move, press against things and meet."""

import numpy as np

from reference.sensing import BODY_RADIUS, OBSTACLE_RADIUS, wrapped

CONTACT_DEPTH = 1e-5

WHEEL_RADIUS = 0.027
WHEEL_SEPARATION = 0.1265
HALF_SEPARATION = WHEEL_SEPARATION / 2
MAX_TURN = 0.5
TICK = 0.1


def arc(heading, wheels):
    """Exact differential drive over one tick.

    Parameters
    ----------
    heading : array (...)
        rad.
    wheels : array (..., 2)
        Left and right wheel speed, rad/s.

    Returns
    -------
    displacement : array (..., 2)
        m.
    turn : array (...)
        rad.
    """
    left, right = np.moveaxis(wheels * WHEEL_RADIUS * TICK, -1, 0)
    length, turn = (left + right) / 2, (right - left) / WHEEL_SEPARATION
    straight = turn == 0
    radius = length / np.where(straight, 1, turn)
    x = np.where(
        straight, length * np.cos(heading), radius * (np.sin(heading + turn) - np.sin(heading))
    )
    y = np.where(
        straight, length * np.sin(heading), radius * (np.cos(heading) - np.cos(heading + turn))
    )
    return np.stack([x, y], axis=-1), turn


def press(poses, wheels, friction, obstacle, wall_contact, size=3.0):
    """One tick of motion against walls and obstacle.

    Walls first: each axis is stopped at its own wall, and what remains of it is shortened by
    ``friction`` times what the other wall stopped. Then the obstacle pushes out along its radius
    and shortens the tangential part of the displacement likewise. A rigid contact turns the robot
    toward the normal by R / b^2 times what friction took; see ``docs/physics.md``.

    Parameters
    ----------
    poses : array (..., 3)
        m, m, rad.
    wheels : array (..., 2)
        rad/s.
    friction : float
    obstacle : bool
    wall_contact : str
        'rigid', 'slide' or 'undo'.
    size : float
        Side of the arena, m.

    Returns
    -------
    poses : array (..., 3)
    contact : bool array (...)
    """
    start, limit = poses[..., :2], size / 2 - BODY_RADIUS
    displacement, turn = arc(poses[..., 2], wheels)
    backward = np.where(wheels.sum(axis=-1) < 0, np.pi, 0)
    wanted = start + displacement
    allowed = np.clip(wanted, -limit, limit)
    stopped = np.abs(wanted - allowed)
    reach = allowed - start
    left = shortened(reach, friction * stopped[..., ::-1])
    end, heading = start + left, poses[..., 2] + turn
    held = stopped.max(axis=-1) > 0
    contact = stopped.max(axis=-1) > CONTACT_DEPTH
    if wall_contact == 'rigid':
        taken = np.abs(reach - left)
        normals = np.where(end[..., 0] < 0, np.pi, 0), np.sign(end[..., 1]) * np.pi / 2
        turns = [
            facing(normal - heading - backward, taken[..., 1 - axis])
            for axis, normal in enumerate(normals)
        ]
        heading = heading + np.where(held, turns[0] + turns[1], 0)
    if obstacle:
        distance = np.hypot(end[..., 0], end[..., 1])[..., None]
        depth = BODY_RADIUS + OBSTACLE_RADIUS - distance
        outward = end / distance
        tangent = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
        surface = end + depth * outward
        along = ((surface - start) * tangent).sum(axis=-1, keepdims=True)
        taken = along - shortened(along, friction * depth)
        inside = depth[..., 0] > 0
        if wall_contact == 'rigid':
            normal = np.arctan2(-outward[..., 1], -outward[..., 0])
            turn = facing(normal - heading - backward, np.abs(taken[..., 0]))
            heading = heading + np.where(inside, turn, 0)
        end = np.where(inside[..., None], surface - taken * tangent, end)
        held = held | inside
        contact = contact | (depth[..., 0] > CONTACT_DEPTH)
    after = np.concatenate([end, heading[..., None]], axis=-1)
    if wall_contact == 'undo':
        after = np.where(held[..., None], poses, after)
    return after, contact


def facing(away, taken):
    """Turn toward a normal that lies at an angle ``away``, rad, where friction took so much, m."""
    away = wrapped(away)
    turn = np.minimum(np.minimum(BODY_RADIUS / HALF_SEPARATION**2 * taken, MAX_TURN), np.abs(away))
    return np.sign(away) * turn


def shortened(length, by):
    """A signed length, ``by`` nearer to zero but not across it."""
    return np.sign(length) * np.maximum(np.abs(length) - by, 0)


def gap(starts, ends):
    """Least distance of the rims while both robots go straight from start to end, (n,), m.

    Not positive where they touch. ``starts`` and ``ends`` are (n, 2, 2).
    """
    before = starts[:, 1] - starts[:, 0]
    change = ends[:, 1] - ends[:, 0] - before
    square = (change**2).sum(axis=-1)
    nearest = np.clip(-(before * change).sum(axis=-1) / np.where(square > 0, square, 1), 0, 1)
    closest = before + nearest[:, None] * change
    return np.hypot(closest[:, 0], closest[:, 1]) - 2 * BODY_RADIUS

"""How the robots move, slide and meet."""

import numpy as np

from reference.sensing import BODY_RADIUS, OBSTACLE_RADIUS

CONTACT_DEPTH = 1e-5

WHEEL_RADIUS = 0.027
WHEEL_SEPARATION = 0.1265
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


def slide(start, displacement, friction, obstacle, size=3.0):
    """Stop at walls and obstacle, slide along them against Coulomb friction.

    Walls first: each axis is stopped at its own wall, and what remains of it is shortened by
    ``friction`` times what the other wall stopped. Then the obstacle pushes out along its radius
    and shortens the tangential part of the displacement likewise.

    Parameters
    ----------
    start, displacement : array (..., 2)
        m.
    friction : float
    obstacle : bool
    size : float
        Side of the arena, m.

    Returns
    -------
    end : array (..., 2)
        m.
    contact : bool array (...)
    """
    limit = size / 2 - BODY_RADIUS
    wanted = start + displacement
    allowed = np.clip(wanted, -limit, limit)
    stopped = np.abs(wanted - allowed)
    end = start + shortened(allowed - start, friction * stopped[..., ::-1])
    contact = stopped.max(axis=-1) > CONTACT_DEPTH
    if obstacle:
        distance = np.hypot(end[..., 0], end[..., 1])[..., None]
        depth = BODY_RADIUS + OBSTACLE_RADIUS - distance
        normal = end / distance
        tangent = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
        along = ((end - start) * tangent).sum(axis=-1, keepdims=True)
        lost = along - shortened(along, friction * depth)
        inside = depth > 0
        end = np.where(inside, end + depth * normal - lost * tangent, end)
        contact = contact | (depth[..., 0] > CONTACT_DEPTH)
    return end, contact


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

"""States to compare at, and how far apart two right answers may lie."""

import numpy as np

from reference.sensing import BODY_RADIUS, OBSTACLE_RADIUS


def scattered(rng, n, obstacle, size=3.0):
    """Poses (n, 2, 3) of robots inside nothing: anywhere, close together, at walls, amid."""
    limit = size / 2 - BODY_RADIUS
    poses = rng.uniform((-limit, -limit, -np.pi), (limit, limit, np.pi), (12 * n, 2, 3))
    poses[::3, 0, :2] *= 0.2
    at_wall = poses[1::3, 0, :2]
    at_wall[...] = np.clip(3 * at_wall, -limit, limit)
    distance, direction = rng.uniform((0.17, -np.pi), (0.4, np.pi), (6 * n, 2)).T
    aside = distance[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    poses[::2, 1, :2] = poses[::2, 0, :2] + aside
    poses = poses.astype(np.float32).astype(float)
    xy = poses[..., :2]
    free = (np.abs(xy) <= limit).all(axis=(1, 2))
    free &= np.hypot(*(xy[:, 1] - xy[:, 0]).T) > 2 * BODY_RADIUS + 1e-6
    if obstacle:
        free &= (np.hypot(xy[..., 0], xy[..., 1]) > BODY_RADIUS + OBSTACLE_RADIUS + 1e-6).all(
            axis=1
        )
    assert free.sum() >= n
    return poses[free][:n]


def envelope(function, poses, by=1e-6, tries=12, seed=0):
    """Least and greatest value of ``function(poses)`` as the poses move by up to ``by`` m and rad.

    A sensor may jump (a ray along the edge of a disc) or steepen beyond all bounds there; float32
    moves a pose by some 1e-7. Whatever lies within the envelope is a right answer.
    """
    rng = np.random.default_rng(seed)
    low = high = function(poses)
    for _ in range(tries):
        value = function(poses + rng.uniform(-by, by, poses.shape))
        low, high = np.minimum(low, value), np.maximum(high, value)
    return low, high


def outside(values, low, high):
    """How far values lie outside their envelope."""
    return np.maximum(np.maximum(low - values, values - high), 0)


def compared(readings):
    """Readings with all infrared distances beyond the range of 0.1 m made equal to it."""
    readings = readings.astype(float)
    readings[..., :24] = np.minimum(readings[..., :24], 0.1)
    return readings

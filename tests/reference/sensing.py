"""What the robots sense: infrared, camera, ground (paper, appendix A1 and A2)."""

import numpy as np

BODY_RADIUS = 0.085
OBSTACLE_RADIUS = 0.05
INFRARED_ANGLES = np.radians(7.5 + 15 * np.arange(24))
SECTOR = np.radians(45)
GROUND_POSITIONS = np.array(
    [(0.0435, 0.049), (0.0435, -0.049), (-0.0435, 0.049), (-0.0435, -0.049)]
)


def sense(poses, contact, obstacle, size=3.0):
    """Readings of all robots.

    Parameters
    ----------
    poses : array (n, 2, 3)
        x, y in m and heading in rad.
    contact : array (n, 2)
        1 where the robot touched a wall or the obstacle during the last tick.
    obstacle : bool
        Whether the cylinder stands at the origin.
    size : float
        Side of the arena, m.

    Returns
    -------
    array (n, 2, 37)
        24 infrared distances (m, inf = nothing), 8 camera sectors, 4 ground sensors, contact.
    """
    return np.concatenate(
        [
            infrared(poses, obstacle, size),
            camera(poses, obstacle),
            ground(poses, size),
            contact[..., None],
        ],
        axis=-1,
    )


def infrared(poses, obstacle, size):
    """Distance from the rim along each of the 24 rays, (n, 2, 24), m."""
    angles = poses[..., 2:] + INFRARED_ANGLES
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    origin = poses[..., None, :2] + BODY_RADIUS * direction
    opponent = poses[:, ::-1, None, :2]
    distance = np.minimum(
        ray_to_walls(origin, direction, size),
        ray_to_disc(origin, direction, opponent, BODY_RADIUS),
    )
    if obstacle:
        distance = np.minimum(
            distance, ray_to_disc(origin, direction, np.zeros(2), OBSTACLE_RADIUS)
        )
    return distance


def ray_to_walls(origin, direction, size):
    """Distance along a ray from inside the arena to its walls."""
    with np.errstate(divide='ignore', invalid='ignore'):
        along_axes = np.where(
            direction == 0, np.inf, (np.sign(direction) * size / 2 - origin) / direction
        )
    return np.maximum(along_axes.min(axis=-1), 0)


def ray_to_disc(origin, direction, centre, radius):
    """Distance along a ray to a disc, inf where it misses, 0 where it starts within."""
    offset = centre - origin
    along = (offset * direction).sum(axis=-1)
    square = radius**2 - (offset**2).sum(axis=-1) + along**2
    half_chord = np.sqrt(np.maximum(square, 0))
    hit = (square >= 0) & (along + half_chord >= 0)
    return np.where(hit, np.maximum(along - half_chord, 0), np.inf)


def camera(poses, obstacle):
    """Fraction of each 45 degree sector that the opponent fills and nothing hides, (n, 2, 8)."""
    opponent = poses[:, ::-1, :2] - poses[..., :2]
    bearing, half, tangent = view(opponent, BODY_RADIUS)
    bearing = bearing - poses[..., 2]
    seen = sector_overlap(bearing - half, bearing + half)
    if obstacle:
        other_bearing, other_half, other_tangent = view(-poses[..., :2], OBSTACLE_RADIUS)
        offset = wrapped(other_bearing - poses[..., 2] - bearing)
        first = np.maximum(offset - other_half, -half)
        last = np.minimum(offset + other_half, half)
        hides = (other_tangent < tangent) & (first < last)
        hidden = sector_overlap(bearing + first, bearing + last)
        seen = seen - np.where(hides[..., None], hidden, 0)
    return seen / SECTOR


def view(offset, radius):
    """Direction and half-width (rad) of a disc seen from the origin, length of tangents (m)."""
    distance = np.hypot(offset[..., 0], offset[..., 1])
    return (
        np.arctan2(offset[..., 1], offset[..., 0]),
        np.arcsin(np.minimum(radius / distance, 1)),
        np.sqrt(np.maximum(distance**2 - radius**2, 0)),
    )


def sector_overlap(first, last):
    """Angle that [first, last] (rad, less than a turn) shares with each of the 8 sectors."""
    turns = np.floor(first / (2 * np.pi)) * 2 * np.pi
    overlap = 0
    for turn in (0, 2 * np.pi):
        start = SECTOR * np.arange(8) + turn
        overlap = overlap + np.maximum(
            np.minimum((last - turns)[..., None], start + SECTOR)
            - np.maximum((first - turns)[..., None], start),
            0,
        )
    return overlap


def wrapped(angle):
    """The same angle in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def ground(poses, size):
    """Darkness under the four ground sensors, (n, 2, 4)."""
    cos, sin = np.cos(poses[..., 2, None]), np.sin(poses[..., 2, None])
    forward, left = GROUND_POSITIONS.T
    x = poses[..., 0, None] + cos * forward - sin * left
    y = poses[..., 1, None] + sin * forward + cos * left
    return np.clip(np.hypot(x, y) / (size / 2 * np.sqrt(2)), 0, 1)

"""The rays of a lidar as the infrared rays of a MarxBot."""

import numpy as np

from marxbot_sensors import INFRARED

RAY_ANGLES = 2 * np.pi * (np.arange(INFRARED.count) + 0.5) / INFRARED.count
"""Where the infrared rays point, rad counter-clockwise from the heading."""


def infrared_ranges(ranges, angle_min, angle_increment, range_min, range_max, yaw=0.0):
    """Return for each infrared ray the least range that a lidar found around it.

    Parameters
    ----------
    ranges : array_like, shape (n,)
        m; what is NaN or out of the lidar's range is not looked at.
    angle_min, angle_increment : float
        Of the lidar's rays, rad counter-clockwise from its forward axis.
    range_min, range_max : float
        Of the lidar, m.
    yaw : float
        Of the lidar in the robot's frame, rad.

    Returns
    -------
    float64 array, shape (24,)
        m; +inf where nothing was found within half a ray's spacing.
    """
    ranges = np.asarray(ranges, float)
    angles = yaw + angle_min + angle_increment * np.arange(len(ranges))
    share = np.mod(angles / (2 * np.pi), 1.0)
    ray = np.minimum((share * INFRARED.count).astype(int), INFRARED.count - 1)
    valid = (ranges >= range_min) & (ranges <= range_max)
    found = np.full(INFRARED.count, np.inf)
    np.minimum.at(found, ray[valid], ranges[valid])
    return found

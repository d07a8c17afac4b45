"""Dead reckoning from the wheels, and how far it may be wrong."""

import math

import numpy as np

from marxbot_sim.core.drive import body_speeds, dead_reckon
from marxbot_sim.core.parameters import TICK, WHEEL_RADIUS, WHEEL_SEPARATION

LEAST_VARIANCE = 1e-9
"""Variance of what is as good as known, m^2 and rad^2: estimators take 0 for a mistake."""


class Odometry:
    """What a robot believes of its pose, from the turns of its wheels alone.

    Each wheel's way over the floor in a tick differs from its turn by a normal error, independent
    of all others, whose standard deviation is a share of the way: the motor noise, and all of the
    way while walls, obstacle or opponent hold the robot. A wrong radius or separation of the
    wheels is a fault of calibration that no robot knows of: it is not contained.

    Attributes
    ----------
    pose : tuple of float
        x and y in m, heading in rad, from 0 at the episode's start.
    covariance : float array, shape (3, 3)
        Of the pose, m and rad, to the first order of the errors.
    speeds : tuple of float
        Forward, m/s, and turning speed, rad/s, in the last tick.
    speed_variances : tuple of float
        Of these.
    """

    def __init__(self):
        self.pose = (0.0, 0.0, 0.0)
        self.covariance = np.zeros((3, 3))
        self.speeds = (0.0, 0.0)
        self.speed_variances = (0.0, 0.0)

    def advance(self, wheels, motor_noise, held):
        """Take in a tick.

        Parameters
        ----------
        wheels : array_like, shape (2,)
            How left and right wheel turned, rad/s.
        motor_noise : float
            Standard deviation of a wheel's way as a fraction of it.
        held : bool
            Whether the robot touched anything.
        """
        self.speeds = linear, angular = body_speeds(wheels)
        share = math.hypot(motor_noise, held)
        left, right = ((WHEEL_RADIUS * share * float(wheel)) ** 2 for wheel in wheels)
        sum_, difference = (left + right) / 4, (right - left) / (2 * WHEEL_SEPARATION)
        turning = (left + right) / WHEEL_SEPARATION**2
        self.speed_variances = sum_, turning
        errors = np.array([[sum_, difference], [difference, turning]]) * TICK**2
        middle = self.pose[2] + angular * TICK / 2
        cosine, sine = math.cos(middle), math.sin(middle)
        way = linear * TICK
        moved = np.array([[1, 0, -way * sine], [0, 1, way * cosine], [0, 0, 1]])
        # What an error of the way, and one of the turn, do to the pose.
        caused = np.array([[cosine, -way * sine / 2], [sine, way * cosine / 2], [0, 1]])
        self.covariance = moved @ self.covariance @ moved.T + caused @ errors @ caused.T
        self.pose = dead_reckon(self.pose, wheels)

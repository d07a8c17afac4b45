"""The controller's view of its robot: each sensor's last message, checked and put in order."""

import math

import numpy as np

from neuro_controller.core.network import (
    CAMERA_READINGS,
    GROUND_READINGS,
    INFRARED_READINGS,
    TOUCH_READING,
)

SENSORS = ('proximity', 'camera', 'ground', 'traction')
"""Topics of the sensors."""

READINGS = TOUCH_READING + 1
_RAYS = CAMERA_READINGS - INFRARED_READINGS
_NEVER = -math.inf


class Sensors:
    """Collects a robot's readings.

    Parameters
    ----------
    contact_threshold : float
        Traction force above which the robot counts as in contact, N.

    Attributes
    ----------
    readings : float32 array, shape (37,)
        24 infrared distances, m; 8 camera sectors; 4 ground sensors; contact.
    """

    def __init__(self, contact_threshold):
        self._contact_threshold = contact_threshold
        self.readings = np.zeros(READINGS, np.float32)
        self._stamps = dict.fromkeys(SENSORS)
        self._received = dict.fromkeys(SENSORS, _NEVER)

    def take(self, sensor, message, now):
        """Take a sensor's message.

        Parameters
        ----------
        sensor : str
            One of `SENSORS`.
        message
            Its message.
        now : float
            Time of its arrival, s.

        Raises
        ------
        ValueError
            The message makes no sense; the readings stay as they were.
        """
        getattr(self, f'_take_{sensor}')(message)
        self._stamps[sensor] = message.header.stamp
        self._received[sensor] = now

    def _take_proximity(self, message):
        distances = np.asarray(message.ranges, np.float32)
        if distances.shape != (_RAYS,):
            raise ValueError(f'proximity has {distances.size} ranges, expected {_RAYS}')
        if np.isnan(distances).any():
            raise ValueError('proximity has a range that is not a number')
        self.readings[INFRARED_READINGS:CAMERA_READINGS] = np.maximum(distances, 0)

    def _take_camera(self, message):
        self.readings[CAMERA_READINGS:GROUND_READINGS] = _fractions('camera', message.sectors)

    def _take_ground(self, message):
        self.readings[GROUND_READINGS:TOUCH_READING] = _fractions('ground', message.darkness)

    def _take_traction(self, message):
        force = math.hypot(message.wrench.force.x, message.wrench.force.y)
        if math.isnan(force):
            raise ValueError('traction has a force that is not a number')
        self.readings[TOUCH_READING] = force > self._contact_threshold

    def common_stamp(self):
        """Return the stamp that all sensors' last messages share; None while they differ."""
        first, *others = self._stamps.values()
        return first if first is not None and all(stamp == first for stamp in others) else None

    def silent(self, now, timeout):
        """Return the names of sensors whose last good message is older than `timeout`, s."""
        return [sensor for sensor in SENSORS if now - self._received[sensor] > timeout]

    def forget(self):
        """Count every sensor as silent."""
        self._stamps = dict.fromkeys(SENSORS)
        self._received = dict.fromkeys(SENSORS, _NEVER)


def _fractions(sensor, values):
    values = np.asarray(values, np.float32)
    if np.isnan(values).any():
        raise ValueError(f'{sensor} has a value that is not a number')
    return np.clip(values, 0, 1)

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
_NANOSECONDS = 10**9
_RAYS = CAMERA_READINGS - INFRARED_READINGS
_NEVER = -math.inf


class Sensors:
    """Collects a robot's readings.

    Parameters
    ----------
    contact_threshold : float
        Traction force above which the robot counts as in contact, N.
    body_radius : float
        What is taken off each range, m: distances count from the body's rim.
    tolerance : float
        By how much the stamps of a complete set may differ, s.

    Attributes
    ----------
    readings : float32 array, shape (37,)
        24 infrared distances, m; 8 camera sectors; 4 ground sensors; contact.
    """

    def __init__(self, contact_threshold, body_radius, tolerance):
        self._contact_threshold = contact_threshold
        self._body_radius = np.float32(body_radius)
        self._tolerance = round(tolerance * _NANOSECONDS)
        self.readings = np.zeros(READINGS, np.float32)
        self.forget()

    def take(self, sensor, message, now, arrival):
        """Take a sensor's message.

        Parameters
        ----------
        sensor : str
            One of `SENSORS`.
        message
            Its message.
        now : float
            Time of its arrival, s.
        arrival : int
            The same by the clock of stamps, ns: taken in place of a stamp of 0, which is none.

        Raises
        ------
        ValueError
            The message makes no sense; the readings stay as they were.
        """
        getattr(self, f'_take_{sensor}')(message)
        stamp = message.header.stamp
        self._stamps[sensor] = stamp.sec * _NANOSECONDS + stamp.nanosec or arrival
        self._received[sensor] = now
        self._fresh.add(sensor)

    def _take_proximity(self, message):
        distances = np.asarray(message.ranges, np.float32)
        if distances.shape != (_RAYS,):
            raise ValueError(f'proximity has {distances.size} ranges, expected {_RAYS}')
        if np.isnan(distances).any():
            raise ValueError('proximity has a range that is not a number')
        distances = np.maximum(distances - self._body_radius, 0)
        self.readings[INFRARED_READINGS:CAMERA_READINGS] = distances

    def _take_camera(self, message):
        self.readings[CAMERA_READINGS:GROUND_READINGS] = _fractions('camera', message.sectors)

    def _take_ground(self, message):
        self.readings[GROUND_READINGS:TOUCH_READING] = _fractions('ground', message.darkness)

    def _take_traction(self, message):
        force = math.hypot(message.wrench.force.x, message.wrench.force.y)
        if math.isnan(force):
            raise ValueError('traction has a force that is not a number')
        self.readings[TOUCH_READING] = force > self._contact_threshold

    def complete_set(self):
        """Return the latest stamp, ns, of a complete set of readings; None where there is none.

        A set has a message of each sensor that no set before had, and their stamps differ by no
        more than the tolerance.
        """
        if len(self._fresh) < len(SENSORS) or self._spread() > self._tolerance:
            return None
        self._fresh.clear()
        return max(self._stamps.values())

    def _spread(self):
        return max(self._stamps.values()) - min(self._stamps.values())

    def why_incomplete(self):
        """Return, as words after 'no complete set of readings', what keeps the next one back."""
        missing = [sensor for sensor in SENSORS if sensor not in self._fresh]
        if missing:
            return f'no new {" and no new ".join(missing)}'
        return (
            f'their stamps differ by {self._spread() / _NANOSECONDS:g} s, more than '
            f'stamp_tolerance, {self._tolerance / _NANOSECONDS:g} s'
        )

    def silent(self, now, timeout):
        """Return the names of sensors whose last good message is older than `timeout`, s."""
        return [sensor for sensor in SENSORS if now - self._received[sensor] > timeout]

    def forget(self):
        """Count every sensor as silent."""
        self._stamps = {}
        self._received = dict.fromkeys(SENSORS, _NEVER)
        self._fresh = set()


def _fractions(sensor, values):
    values = np.asarray(values, np.float32)
    if np.isnan(values).any():
        raise ValueError(f'{sensor} has a value that is not a number')
    return np.clip(values, 0, 1)

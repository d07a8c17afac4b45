"""The controller's view of its robot: each sensor's last message, checked and put in order."""

import math

import numpy as np

from marxbot_sensors import CAMERA, GROUND, INFRARED, MARXBOT, TOUCH

_NANOSECONDS = 10**9
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
    robot : marxbot_sensors.Robot
        Whose sensors they are.

    Attributes
    ----------
    readings : float32 array, shape (robot.readings,)
        What the robot's sensors read, in their order.
    """

    def __init__(self, contact_threshold, body_radius, tolerance, robot=MARXBOT):
        self._robot = robot
        self._sensors = {sensor.topic: sensor for sensor in robot.sensors}
        self._contact_threshold = contact_threshold
        self._body_radius = np.float32(body_radius)
        self._tolerance = round(tolerance * _NANOSECONDS)
        self.readings = np.zeros(robot.readings, np.float32)
        self.forget()

    def take(self, sensor, message, now, arrival):
        """Take a sensor's message.

        Parameters
        ----------
        sensor : str
            Its topic.
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
        self._take(self._sensors[sensor], message)
        stamp = message.header.stamp
        self._stamps[sensor] = stamp.sec * _NANOSECONDS + stamp.nanosec or arrival
        self._received[sensor] = now
        self._fresh.add(sensor)

    def _take(self, sensor, message):
        """Put a sensor's message among the readings."""
        if sensor == INFRARED:
            values = self._distances(message)
        elif sensor == TOUCH:
            values = self._contact(message)
        else:
            field = {CAMERA: 'sectors', GROUND: 'darkness'}.get(sensor, 'values')
            values = _within(sensor, getattr(message, field))
        if len(values) != sensor.count:
            raise ValueError(f'{sensor.topic} has {len(values)} values, expected {sensor.count}')
        self.readings[self._robot.rows(sensor)] = values

    def _distances(self, message):
        distances = np.asarray(message.ranges, np.float32)
        if np.isnan(distances).any():
            raise ValueError('proximity has a range that is not a number')
        return np.maximum(distances - self._body_radius, 0)

    def _contact(self, message):
        force = math.hypot(message.wrench.force.x, message.wrench.force.y)
        if math.isnan(force):
            raise ValueError('traction has a force that is not a number')
        return [force > self._contact_threshold]

    def complete_set(self):
        """Return the latest stamp, ns, of a complete set of readings; None where there is none.

        A set has a message of each sensor that no set before had, and their stamps differ by no
        more than the tolerance.
        """
        if len(self._fresh) < len(self._sensors) or self._spread() > self._tolerance:
            return None
        self._fresh.clear()
        return max(self._stamps.values())

    def _spread(self):
        return max(self._stamps.values()) - min(self._stamps.values())

    def why_incomplete(self):
        """Return, as words after 'no complete set of readings', what keeps the next one back."""
        missing = [sensor for sensor in self._sensors if sensor not in self._fresh]
        if missing:
            return f'no new {" and no new ".join(missing)}'
        return (
            f'their stamps differ by {self._spread() / _NANOSECONDS:g} s, more than '
            f'stamp_tolerance, {self._tolerance / _NANOSECONDS:g} s'
        )

    def silent(self, now, timeout):
        """Return the names of sensors whose last good message is older than `timeout`, s."""
        return [sensor for sensor in self._sensors if now - self._received[sensor] > timeout]

    def forget(self):
        """Count every sensor as silent."""
        self._stamps = {}
        self._received = dict.fromkeys(self._sensors, _NEVER)
        self._fresh = set()


def _within(sensor, values):
    """Return a message's values, kept in the sensor's range."""
    values = np.asarray(values, np.float32)
    if np.isnan(values).any():
        raise ValueError(f'{sensor.topic} has a value that is not a number')
    return np.clip(values, sensor.low, sensor.high)

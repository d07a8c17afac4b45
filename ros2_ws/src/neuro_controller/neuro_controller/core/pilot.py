"""A controller at the wheel: from readings to the body's speeds, within limits."""

import numpy as np

from neuro_controller.core.drive import WHEEL_RADIUS, WHEEL_SEPARATION, body_speeds
from neuro_controller.core.limits import Limits

PERIOD = 0.1
"""Time between two steps, s: that of evolution (paper A1), in which clock and fatigue neurons
count."""

STOP = (0.0, 0.0)
"""The command that stops a robot: linear and angular speed."""


class Pilot:
    """Turns the readings of one robot into commands for its body.

    Parameters
    ----------
    controller : neuro_controller.core.controller.Controller
    limits : Limits
    wheel_radius, wheel_separation : float
        Of the wheels that the network believes in, m.

    Attributes
    ----------
    command : tuple of float
        The present command: linear, m/s, and angular speed, rad/s.
    """

    def __init__(
        self,
        controller,
        limits=Limits(),  # noqa: B008  frozen
        wheel_radius=WHEEL_RADIUS,
        wheel_separation=WHEEL_SEPARATION,
    ):
        self.controller = controller
        self.limits = limits
        self._wheels = (wheel_radius, wheel_separation)
        self.command = STOP
        self._answered = None

    def reset(self):
        """Forget the past, as at the start of an episode."""
        self.controller.reset()
        self.command = STOP
        self._answered = None

    def stop(self):
        """Command a stop; the network keeps its state."""
        self.command = STOP

    def step(self, readings):
        """Run the network for one tick and set `command`.

        Parameters
        ----------
        readings : float32 array, shape (robot.readings,)
            See `Controller.step`.
        """
        wanted = body_speeds(self.controller.step(readings), *self._wheels)
        self.command = self.limits.apply(wanted, self.command, PERIOD)

    def answer(self, stamp, readings):
        """Set `command` for the readings of time `stamp`; asked twice, it answers the same.

        Readings that are no later than the last ones, and other than those, begin a new episode.

        Parameters
        ----------
        stamp : tuple
            Time of the readings, in an order.
        readings : float32 array, shape (robot.readings,)

        Returns
        -------
        bool
            Whether they began a new episode.
        """
        begins = False
        if self._answered is not None:
            last_stamp, last_readings = self._answered
            if stamp == last_stamp and np.array_equal(readings, last_readings):
                return False
            begins = stamp <= last_stamp
            if begins:
                self.reset()
        self._answered = stamp, readings.copy()
        self.step(readings)
        return begins

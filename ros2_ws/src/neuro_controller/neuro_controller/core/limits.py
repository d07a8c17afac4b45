"""Limits on what a controller may ask of a robot."""

import math
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Limits:
    """Highest speeds and accelerations of the body; infinite ones leave commands untouched.

    Attributes
    ----------
    linear_speed, angular_speed
        Highest speed, m/s and rad/s, above 0. A command beyond one is slowed down as a whole: its
        curve stays.
    linear_acceleration, angular_acceleration
        Highest acceleration, m/s^2 and rad/s^2, above 0; braking counts as well.

    Raises
    ------
    ValueError
        A limit is not above 0.
    """

    linear_speed: float = math.inf
    angular_speed: float = math.inf
    linear_acceleration: float = math.inf
    angular_acceleration: float = math.inf

    def __post_init__(self):
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0:
                raise ValueError(
                    f'{field.name} is {value}, expected a number above 0 (.inf: no limit)'
                )

    def apply(self, command, previous, period):
        """Return the command that keeps within the limits.

        Parameters
        ----------
        command, previous : tuple of float
            Linear and angular speed, m/s and rad/s: as wanted, and as sent last.
        period : float
            Time since `previous` was sent, s.
        """
        linear, angular = command
        excess = max(abs(linear) / self.linear_speed, abs(angular) / self.angular_speed)
        if excess > 1:
            linear, angular = linear / excess, angular / excess
        return (
            _approach(linear, previous[0], self.linear_acceleration * period),
            _approach(angular, previous[1], self.angular_acceleration * period),
        )


def _approach(wanted, previous, change):
    if abs(wanted - previous) <= change:
        return wanted
    return previous + math.copysign(change, wanted - previous)

"""From wheel speeds to the body's speeds, for a robot that takes a Twist."""

BODY_RADIUS = 0.085
"""Radius of a MarxBot's body, m (paper A1)."""

WHEEL_RADIUS = 0.027
"""Radius of a MarxBot's wheel, m (FARSA)."""

WHEEL_SEPARATION = 0.1265
"""Distance between a MarxBot's wheels, m (FARSA)."""


def body_speeds(wheels, wheel_radius=WHEEL_RADIUS, wheel_separation=WHEEL_SEPARATION):
    """Return the forward speed, m/s, and the turning speed, rad/s, of the body.

    Computed in float64 from wheel speeds on the controller's grid of 2**-16 rad/s, so that whoever
    converts back and rounds to that grid has the wheel speeds again, bit for bit.

    Parameters
    ----------
    wheels : array_like, shape (2,)
        Speeds of the left and right wheel, rad/s.
    """
    left, right = float(wheels[0]), float(wheels[1])
    return wheel_radius * (left + right) / 2, wheel_radius * (right - left) / wheel_separation

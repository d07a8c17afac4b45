"""The commands of both robots: received, checked, and watched for silence."""

import numpy as np

from marxbot_sim.core.drive import wheel_speeds
from marxbot_sim.core.parameters import ROBOTS, TICK
from marxbot_sim.interface import command_topic


class Commands:
    """What the wheels of both robots shall do.

    Parameters
    ----------
    node : rclpy.node.Node
    parameters : marxbot_sim.node_parameters.Parameters
    warn : callable
        Logs a sentence.
    on_command : callable
        Called after each command that was taken.

    Attributes
    ----------
    wheels : float32 array, shape (2, 2)
        Commanded speeds of left and right wheel, rad/s.
    answered : set
        Numbers of the robots whose command for the present readings was taken.
    refused : list of int
        How many commands of each robot made no sense.
    """

    def __init__(self, node, parameters, warn, on_command):
        self._warn = warn
        self._on_command = on_command
        self._lockstep = parameters['lockstep']
        self._stamped = parameters['stamped_cmd_vel']
        self._limit = parameters['max_wheel_speed']
        self._timeout_ticks = parameters['cmd_vel_timeout'] / TICK
        self.refused = [0] * len(ROBOTS)
        self.begin()
        for number, robot in enumerate(ROBOTS):
            topic = command_topic(robot, self._stamped)
            node.create_subscription(
                topic.type,
                topic.name,
                lambda message, number=number: self._take(number, message),
                topic.qos,
            )

    def begin(self):
        """Start an episode: no command yet."""
        self.wheels = np.zeros((2, 2), np.float32)
        self._ages = [0, 0]
        self.answered = set()
        self._stamp = None

    def expect(self, stamp):
        """Expect answers to the readings of time `stamp`, which are published now."""
        self._stamp = stamp
        self.answered = set()

    @property
    def missing(self):
        """Names of the robots that have not answered the present readings."""
        return [robot for number, robot in enumerate(ROBOTS) if number not in self.answered]

    def _take(self, number, message):
        """Take a command; in lockstep, only the first that answers the present readings."""
        if self._lockstep and (self._stamp is None or number in self.answered):
            return
        twist = message.twist if self._stamped else message
        if self._lockstep and self._stamped and message.header.stamp != self._stamp:
            self._warn(f'{ROBOTS[number]}: ignored a command for other readings than the present')
            return
        self.wheels[number] = self._wheels(number, twist)
        self._ages[number] = 0
        self.answered.add(number)
        self._on_command()

    def _wheels(self, number, twist):
        linear, angular = twist.linear.x, twist.angular.z
        try:
            wheels, limited = wheel_speeds(linear, angular, self._limit)
        except ValueError as error:
            self.refused[number] += 1
            self._warn(f'{ROBOTS[number]} stopped by a bad cmd_vel: {error}')
            return np.zeros(2, np.float32)
        if limited:
            self._warn(
                f'{ROBOTS[number]} slowed down: cmd_vel asks {linear:g} m/s and {angular:g} rad/s,'
                f' more than wheels of {self._limit:g} rad/s can do'
            )
        return wheels

    def stop_silent(self):
        """Count a tick, and stop the robots that have had no command for too long."""
        for number, robot in enumerate(ROBOTS):
            self._ages[number] += 1
            if self._ages[number] > self._timeout_ticks and self.wheels[number].any():
                self.wheels[number] = 0
                self._warn(f'{robot} stopped: no cmd_vel for {self._ages[number] * TICK:.1f} s')

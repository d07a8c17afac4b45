"""What the simulator tells about itself on /diagnostics."""

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType

from marxbot_sim.core.simulation import ROBOTS

PERIOD = 1.0
"""Time between two reports, s (real time)."""


class Monitor:
    """Counts ticks and refused commands, and reports them once a second.

    Parameters
    ----------
    node : rclpy.node.Node
        The simulator; its `status` gives the rest of the report.
    """

    def __init__(self, node):
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._refused = [0] * len(ROBOTS)
        self._ticks = 0
        self._reported_at = time.monotonic()
        node.create_timer(PERIOD, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def ticked(self):
        """Count a tick."""
        self._ticks += 1

    def refused(self, number):
        """Count a command that was refused."""
        self._refused[number] += 1

    def _report(self):
        now = time.monotonic()
        rate = self._ticks / (now - self._reported_at)
        self._ticks, self._reported_at = 0, now
        level, message, values = self._node.status()
        values['ticks per second of real time'] = f'{rate:.1f}'
        for robot, count in zip(ROBOTS, self._refused, strict=True):
            values[f'refused commands of {robot}'] = str(count)
        report = DiagnosticArray()
        report.header.stamp = self._node.stamp
        report.status = [
            DiagnosticStatus(
                level=level,
                name=f'{self._node.get_fully_qualified_name().lstrip("/")}: episode',
                message=message,
                hardware_id='marxbot_sim',
                values=[KeyValue(key=key, value=value) for key, value in values.items()],
            )
        ]
        self._publisher.publish(report)

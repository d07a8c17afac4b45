"""What the simulator tells about itself on /diagnostics."""

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType

PERIOD = 1.0
"""Time between two reports, s (real time)."""


class Monitor:
    """Counts ticks, and reports once a second.

    Parameters
    ----------
    node : rclpy.node.Node
        The simulator; its `status` gives the rest of the report.
    publisher : rclpy.publisher.Publisher
        Of the reports.
    """

    def __init__(self, node, publisher):
        self._node = node
        self._publisher = publisher
        self._ticks = 0
        self._reported_at = time.monotonic()
        node.create_timer(PERIOD, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def ticked(self):
        """Count a tick."""
        self._ticks += 1

    def _report(self):
        now = time.monotonic()
        rate = self._ticks / (now - self._reported_at)
        self._ticks, self._reported_at = 0, now
        level, message, values = self._node.status()
        values['ticks per second of real time'] = f'{rate:.1f}'
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

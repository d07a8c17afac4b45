"""Warnings that do not flood the log."""

import time

from rclpy.impl.rcutils_logger import RcutilsLogger

PERIOD = 5.0
"""Shortest time between two complaints about the same, s."""


class Complaints:
    """Logs warnings; what comes again too soon is left out.

    Two texts are about the same when they are equal up to their first colon.

    Parameters
    ----------
    logger
        Of a node.
    """

    def __init__(self, logger: RcutilsLogger) -> None:
        self._logger = logger
        self._logged_at: dict[str, float] = {}

    def warn(self, text: str) -> None:
        """Log a sentence such as ``'predator stopped: no cmd_vel for 0.5 s'``."""
        if self._due(text):
            self._logger.warning(text)

    def error(self, text):
        """Log likewise, as an error."""
        if self._due(text):
            self._logger.error(text)

    def _due(self, text):
        subject = text.partition(':')[0]
        now = time.monotonic()
        due = now - self._logged_at.get(subject, -PERIOD) >= PERIOD
        if due:
            self._logged_at[subject] = now
        return due

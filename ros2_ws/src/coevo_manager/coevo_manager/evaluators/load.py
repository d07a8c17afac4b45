"""How busy one evaluator is."""

from __future__ import annotations


class Load:
    """Time in which something was asked of an evaluator, and episodes that it answered.

    Parameters
    ----------
    now : float
        Time from which it is counted, s; the clock of all other times.

    Attributes
    ----------
    episodes : int
        Answered since `since_last`.
    """

    def __init__(self, now: float) -> None:
        self.episodes = 0
        self._busy = False
        self._busy_seconds = 0.0
        self._changed = self._asked = now

    def busy(self, now: float, busy: bool) -> None:
        """Note whether there are questions under way from now on."""
        if self._busy:
            self._busy_seconds += now - self._changed
        self._busy, self._changed = busy, now

    def since_last(self, now: float) -> tuple[float, float]:
        """Return the busy share of the time and the episodes a second since this was called."""
        self.busy(now, self._busy)
        seconds = max(now - self._asked, 1e-9)
        share, rate = self._busy_seconds / seconds, self.episodes / seconds
        self._busy_seconds, self.episodes, self._asked = 0.0, 0, now
        return min(share, 1.0), rate

"""What is to be known of a sensor."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Sensor:
    """A sensor of a robot, and the sensory neurons that it drives.

    Attributes
    ----------
    name : str
    topic : str
        Where it is published, below the robot's namespace.
    count : int
        Numbers that it reads.
    low, high : float
        Range of these.
    unit : str
        Of these; '' for shares and truth values.
    reads : str
        What the numbers are, for people.
    neurons : int
        Sensory neurons that it drives.
    neurons_are : str
        What the neurons are, for people.
    sense : callable, optional
        How simulators compute what it reads, for sensors beyond `MARXBOT`'s: a kernel part
        ``sense(bodies, arena, first, readings)`` that stores its numbers in the rows of
        ``readings`` from ``first`` on.

    Raises
    ------
    ValueError
        A count or the range makes no sense, in one sentence.
    """

    name: str
    topic: str
    count: int
    low: float
    high: float
    unit: str
    reads: str
    neurons: int
    neurons_are: str
    sense: Callable[..., None] | None = field(default=None, repr=False, compare=False)

    @property
    def text(self) -> str:
        """What it reads, how many numbers, in which range and unit, for people."""
        unit = f' {self.unit}' if self.unit else ''
        numbers = 'number' if self.count == 1 else 'numbers'
        return f'{self.count} {numbers}, {self.low:g} to {self.high:g}{unit}: {self.reads}'

    def __post_init__(self) -> None:
        for what in ('count', 'neurons'):
            if getattr(self, what) < 1:
                raise ValueError(
                    f'{what} of sensor {self.name} is {getattr(self, what)}, expected at least 1'
                )
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError(
                f'range of sensor {self.name} is {self.low} to {self.high}, expected a lower and '
                'a higher finite number'
            )

"""The MarxBot's sensors (paper A1, A2), and robots that have further ones."""

from __future__ import annotations

from dataclasses import dataclass

from marxbot_sensors.sensor import Sensor

INFRARED = Sensor(
    name='infrared',
    topic='proximity',
    count=24,
    low=0.0,
    high=0.1,
    unit='m',
    reads="distances from the body's rim, ray i at 7.5 + 15 i degrees from the heading",
    neurons=8,
    neurons_are='8 infrared groups',
)
"""Three neighbouring rays make a neuron, the mean of their activations. Beyond the range nothing
is seen."""

CAMERA = Sensor(
    name='camera',
    topic='camera',
    count=8,
    low=0.0,
    high=1.0,
    unit='',
    reads="share of each sector that the opponent's lights fill, sector k from 45 k to 45 (k + 1) "
    'degrees from the heading',
    neurons=9,
    neurons_are='8 camera sectors, their mean',
)

GROUND = Sensor(
    name='ground',
    topic='ground',
    count=4,
    low=0.0,
    high=1.0,
    unit='',
    reads='darkness under the body: front left, front right, rear left, rear right',
    neurons=5,
    neurons_are='4 ground sensors, their mean',
)

TOUCH = Sensor(
    name='touch',
    topic='traction',
    count=1,
    low=0.0,
    high=1.0,
    unit='',
    reads='contact, 0 or 1',
    neurons=1,
    neurons_are='contact',
)


_MARXBOT = (INFRARED, CAMERA, GROUND, TOUCH)


@dataclass(frozen=True)
class Robot:
    """The sensors of a robot, in the order of its readings and of its sensory neurons.

    Parameters
    ----------
    sensors : tuple of Sensor
        Infrared, camera, ground and touch, which the kernels know, then any further ones. Each
        number of a further sensor drives a neuron, which is 0 at the low end of the sensor's range
        and 1 at its high end.

    Raises
    ------
    ValueError
        In one sentence: the first sensors are others, a further one has not one neuron for each
        number, or two share a name or a topic.
    """

    sensors: tuple[Sensor, ...] = _MARXBOT

    def __post_init__(self) -> None:
        if self.sensors[: len(_MARXBOT)] != _MARXBOT:
            names = ', '.join(sensor.name for sensor in self.sensors)
            raise ValueError(
                f'sensors are {names}, expected infrared, camera, ground and touch before others'
            )
        for sensor in self.further:
            if sensor.neurons != sensor.count:
                raise ValueError(
                    f'neurons of sensor {sensor.name} is {sensor.neurons}, expected its count, '
                    f'{sensor.count}'
                )
        for what in ('name', 'topic'):
            values = [getattr(sensor, what) for sensor in self.sensors]
            for value in values:
                if values.count(value) > 1:
                    raise ValueError(f'{value} is the {what} of two sensors, expected one')

    @property
    def further(self) -> tuple[Sensor, ...]:
        """The sensors beyond those of a MarxBot."""
        return self.sensors[len(_MARXBOT) :]

    @property
    def readings(self) -> int:
        """Numbers that the sensors read together."""
        return sum(sensor.count for sensor in self.sensors)

    @property
    def neurons(self) -> int:
        """Sensory neurons that the sensors drive."""
        return sum(sensor.neurons for sensor in self.sensors)

    def rows(self, sensor: Sensor) -> slice:
        """Return where a sensor's numbers lie among the readings."""
        return self._place(sensor, 'count')

    def inputs(self, sensor: Sensor) -> slice:
        """Return where a sensor's neurons lie among the sensory neurons."""
        return self._place(sensor, 'neurons')

    def _place(self, sensor: Sensor, what: str) -> slice:
        before = self.sensors[: self.sensors.index(sensor)]
        first = sum(getattr(other, what) for other in before)
        return slice(first, first + getattr(sensor, what))

    @property
    def scales(self) -> tuple[float, ...]:
        """What a number of touch or a further sensor is multiplied with to become its neuron."""
        return tuple(1 / (sensor.high - sensor.low) for sensor in self._direct)

    @property
    def offsets(self) -> tuple[float, ...]:
        """What is added to that."""
        return tuple(-sensor.low / (sensor.high - sensor.low) for sensor in self._direct)

    @property
    def _direct(self) -> list[Sensor]:
        """The sensor of each number that drives a neuron of its own, as it is."""
        return [sensor for sensor in (TOUCH, *self.further) for _ in range(sensor.count)]

    @property
    def neurons_are(self) -> str:
        """What the sensory neurons are, for people."""
        return ', '.join(sensor.neurons_are for sensor in self.sensors)


MARXBOT = Robot()
"""The paper's robot."""

"""Imperfect sensors and motors: what separates a simulated robot from a real one.

Noise, latency and loss act between the world and the controller, on one robot's arrays, so that any
physics and any way of running an episode can use them. Everything is off by default, and off means
off: the arrays pass through untouched.
"""

from collections import deque
from dataclasses import dataclass, fields

import numpy as np

from marxbot_sim.core.parameters import CAMERA_SECTORS, GROUND_POSITIONS, INFRARED_RANGE, INFRARED_RAYS

_INFRARED = slice(0, INFRARED_RAYS)
_CAMERA = slice(_INFRARED.stop, _INFRARED.stop + CAMERA_SECTORS)
_GROUND = slice(_CAMERA.stop, _CAMERA.stop + len(GROUND_POSITIONS))
_NOISY = _GROUND.stop


@dataclass(frozen=True)
class Perturbations:
    """How far one robot's sensors and motors are from perfect.

    Attributes
    ----------
    infrared_noise
        Standard deviation of the noise on an infrared distance, m. Only what is within range is
        disturbed; it may leave the range and so be lost.
    camera_noise
        Standard deviation of the noise on a camera sector's fraction; the result is kept in [0, 1].
    ground_noise
        Standard deviation of the noise on a ground sensor's darkness; the result is kept in [0, 1].
    motor_noise
        Standard deviation of a wheel's speed as a fraction of its command (0.05: 5 %).
    latency_ticks
        Ticks by which a wheel command takes effect late; the wheels stand still until the first one.
    command_loss
        Probability that a tick's command is lost and the wheels keep the previous one, [0, 1].
    seed
        Seed of everything random here, >= 0.

    Raises
    ------
    ValueError
        A field is out of its range.
    """

    infrared_noise: float = 0.0
    camera_noise: float = 0.0
    ground_noise: float = 0.0
    motor_noise: float = 0.0
    latency_ticks: int = 0
    command_loss: float = 0.0
    seed: int = 0

    def __post_init__(self):
        for field in fields(self):
            value = getattr(self, field.name)
            whole = field.type is int
            if whole and (isinstance(value, bool) or value != int(value)):
                raise ValueError(f'{field.name} is {value}, expected a whole number')
            if not 0 <= value < np.inf:
                raise ValueError(f'{field.name} is {value}, expected a finite number, 0 or more')
        if self.command_loss > 1:
            raise ValueError(f'command_loss is {self.command_loss}, expected a probability, 0 to 1')


class PerturbedRobot:
    """The state of one robot's perturbations during an episode.

    Every tick draws the same number of random values whatever the amplitudes are, from one stream
    for the sensors and one for the motors. So the same seed gives the same sequence (common random
    numbers) when one amplitude is changed or two controllers are compared.

    Parameters
    ----------
    perturbations
        What is disturbed, and how much.
    robot
        Number of the robot; each has streams of its own.
    """

    def __init__(self, perturbations: Perturbations, robot: int):
        self._perturbations = perturbations
        self._robot = robot
        p = perturbations
        self._sensing = p.infrared_noise > 0 or p.camera_noise > 0 or p.ground_noise > 0
        self._moving = p.motor_noise > 0 or p.latency_ticks > 0 or p.command_loss > 0
        self._deviation = np.zeros(_NOISY, np.float32)
        self._deviation[_INFRARED] = p.infrared_noise
        self._deviation[_CAMERA] = p.camera_noise
        self._deviation[_GROUND] = p.ground_noise
        self.reset()

    def reset(self, episode: int = 0):
        """Start an episode; the same `episode` number repeats the same random values."""
        sensors, motors = np.random.SeedSequence(
            [self._perturbations.seed, episode, self._robot]
        ).spawn(2)
        self._sensor_rng = np.random.default_rng(sensors)
        self._motor_rng = np.random.default_rng(motors)
        self._held = np.zeros(2, np.float32)
        self._queue = deque(
            [np.zeros(2, np.float32)] * self._perturbations.latency_ticks
        )

    def sense(self, readings: np.ndarray) -> np.ndarray:
        """Return what the robot reads this tick.

        Parameters
        ----------
        readings
            float32 ``(37,)``: true readings in the order of `marxbot_sim.core.world.World`.
        """
        if not self._sensing:
            return readings
        noise = self._sensor_rng.standard_normal(_NOISY, dtype=np.float32)
        noisy = readings.copy()
        noisy[:_NOISY] += self._deviation * noise
        unseen = readings[_INFRARED] > INFRARED_RANGE
        noisy[_INFRARED] = np.where(
            unseen, readings[_INFRARED], np.maximum(noisy[_INFRARED], np.float32(0))
        )
        fractions = slice(_CAMERA.start, _GROUND.stop)
        np.clip(noisy[fractions], 0, 1, out=noisy[fractions])
        return noisy

    def drive(self, command: np.ndarray) -> np.ndarray:
        """Return the wheel speeds this tick's command results in.

        Parameters
        ----------
        command
            float32 ``(2,)``: commanded left and right wheel speed, rad/s.
        """
        if not self._moving:
            return command
        lost = self._motor_rng.random() < self._perturbations.command_loss
        noise = self._motor_rng.standard_normal(2, dtype=np.float32)
        if not lost:
            self._held = np.array(command, np.float32)
        self._queue.append(self._held)
        factor = 1 + np.float32(self._perturbations.motor_noise) * noise
        return self._queue.popleft() * factor

"""Perturbations at work on the 16 robots of a batch, and on the two of one arena."""

import math
from collections import namedtuple

import numba
import numpy as np

from marxbot_sim.core.layout import (
    CAMERA,
    CONTACT,
    COSINE,
    GROUND,
    INFRARED,
    LEFT,
    READING_ROWS,
    RIGHT,
    SINE,
    TOUCH,
    WHEEL_ROWS,
    X,
    Y,
)
from marxbot_sim.core.parameters import BODY_RADIUS, INFRARED_RANGE, START_POSES
from marxbot_sim.core.perturbations import MAX_LATENCY_TICKS, PERFECT
from marxbot_sim.core.randomness import NORMAL_BITS, normal, random_bits, uniform
from marxbot_sim.core.world import ROBOT_LANES
from simd_lanes import (
    HALF,
    LANES,
    aligned_rows,
    compile_kernel,
    fma,
    load,
    maximum,
    minimum,
    select,
    store,
)

(
    INFRARED_NOISE,
    CAMERA_NOISE,
    GROUND_NOISE,
    MOTOR_NOISE,
    LATENCY,
    SPEED_LIMIT,
    LOSS,
    RADIUS_SCALE,
    SEPARATION_SCALE,
    DISPLACEMENT,
    ROTATION,
) = range(11)
SETTING_ROWS = 11


_PER_NUMBER = 60 // NORMAL_BITS  # normal values from one random number
_SENSOR_NUMBERS = -(-TOUCH // _PER_NUMBER)
_MOTORS, _PLACE, _TURN = 8, 9, 10  # the numbers of a tick: 0 to 7 for the sensors, then these
_PER_TICK = 16
_SLOTS = MAX_LATENCY_TICKS + 1
_STARTS = np.array(START_POSES)

Disturbance = namedtuple('Disturbance', 'settings keys ages noise held queue turning rolling')
"""State of the perturbations of 16 robots.

settings : float32 (SETTING_ROWS, 16), by robot
keys : uint64 (16,), of the episode's random numbers
ages : int64 (16,), ticks since the episode's start
noise : float32 (40, 16), what was drawn for the sensors in this tick
held : float32 (2, 16), last command that was not lost, rad/s
queue : float32 (22, 16), commands of the last ticks, rad/s
turning : float32 (2, 16), speeds of the wheels as their encoders count them, rad/s
rolling : float32 (2, 16), wheel speeds with which a perfect robot would move as this one does
"""


def make_disturbance(perturbations, max_wheel_speeds):
    """Return the state for a batch of robots that are all at the start of episode 0.

    Parameters
    ----------
    perturbations : Perturbations
    max_wheel_speeds : sequence of two floats
        Highest wheel speeds of predator and prey, rad/s: what a full battery gives.

    Returns
    -------
    Disturbance, or None where nothing is imperfect
    """
    p = perturbations
    if not p.active:
        return None
    settings = aligned_rows(SETTING_ROWS)
    for robot, (name, speed) in enumerate(
        zip(('predator', 'prey'), max_wheel_speeds, strict=True)
    ):
        own = p if p.robots in ('both', name) else PERFECT
        settings[:, robot * HALF : robot * HALF + HALF] = np.array(
            [
                own.infrared_noise,
                own.camera_noise,
                own.ground_noise,
                own.motor_noise,
                own.latency_ticks,
                own.battery * speed if own.battery < 1 else math.inf,
                own.command_loss,
                own.wheel_radius_scale,
                own.wheel_separation_scale,
                own.start_displacement,
                own.start_rotation,
            ]
        )[:, None]
    disturbance = Disturbance(
        settings,
        np.zeros(LANES, np.uint64),
        np.zeros(LANES, np.int64),
        aligned_rows(_PER_NUMBER * _SENSOR_NUMBERS),
        aligned_rows(WHEEL_ROWS),
        aligned_rows(WHEEL_ROWS * _SLOTS),
        aligned_rows(WHEEL_ROWS),
        aligned_rows(WHEEL_ROWS),
    )
    for lane in range(LANES):
        begin(disturbance, lane, p.seed, 0)
    return disturbance


@numba.njit
def _episode_key(seed, episode, lane):
    return random_bits(random_bits(np.uint64(seed), episode), lane // HALF)


@compile_kernel
def begin(disturbance, lane, seed, episode):
    """Begin the episode of that number, an integer >= 0, in a robot's lane."""
    disturbance.keys[lane] = _episode_key(seed, episode, lane)
    disturbance.ages[lane] = 0
    disturbance.held[LEFT, lane] = disturbance.held[RIGHT, lane] = 0.0


@compile_kernel
def start_pose(disturbance, lane, seed, episode):
    """Return where that episode starts for the robot of a lane: x and y in m, heading in rad."""
    key = _episode_key(seed, episode, lane)
    place, turn = random_bits(key, _PLACE), random_bits(key, _TURN)
    radius = disturbance.settings[DISPLACEMENT, lane] * math.sqrt(uniform(place))
    direction = 2.0 * math.pi * uniform(place << np.uint64(24))
    rotation = disturbance.settings[ROTATION, lane] * (2.0 * uniform(turn) - 1.0)
    robot = lane // HALF
    return (
        _STARTS[robot, 0] + radius * math.cos(direction),
        _STARTS[robot, 1] + radius * math.sin(direction),
        _STARTS[robot, 2] + rotation,
    )


@numba.njit
def begin_at(disturbance, lane, seed, episode, bodies):
    """Begin an episode in a robot's lane and put the robot where it starts, at rest."""
    begin(disturbance, lane, seed, episode)
    x, y, heading = start_pose(disturbance, lane, seed, episode)
    bodies[X, lane], bodies[Y, lane], bodies[CONTACT, lane] = x, y, 0.0
    bodies[COSINE, lane], bodies[SINE, lane] = math.cos(heading), math.sin(heading)


@numba.njit
def _draw(disturbance):
    """Draw the tick's 36 sensor values for each robot."""
    keys, ages, noise = disturbance.keys, disturbance.ages, disturbance.noise
    for lane in range(LANES):
        first = ages[lane] * _PER_TICK
        for number in range(_SENSOR_NUMBERS):
            bits = random_bits(keys[lane], first + number)
            for index in range(_PER_NUMBER):
                noise[_PER_NUMBER * number + index, lane] = normal(bits, index)


@compile_kernel
def disturb_readings(disturbance, readings):
    """Add the tick's noise to what the robots sense, float32 (READING_ROWS, 16)."""
    _draw(disturbance)
    settings, noise = disturbance.settings, disturbance.noise
    deviation = load(settings, INFRARED_NOISE)
    for row in range(INFRARED, CAMERA):
        true = load(readings, row)
        noisy = maximum(fma(deviation, load(noise, row), true), 0.0)
        # As every distance: what a float32 distance from the centre, less the radius, can be.
        noisy = (noisy + BODY_RADIUS) - BODY_RADIUS
        store(readings, row, select(true > INFRARED_RANGE, true, noisy))
    _disturb_fractions(settings, CAMERA_NOISE, noise, readings, CAMERA, GROUND)
    _disturb_fractions(settings, GROUND_NOISE, noise, readings, GROUND, TOUCH)


@numba.njit
def _disturb_fractions(settings, setting, noise, readings, first, end):
    deviation = load(settings, setting)
    for row in range(first, end):
        noisy = fma(deviation, load(noise, row), load(readings, row))
        store(readings, row, minimum(maximum(noisy, 0.0), 1.0))


@compile_kernel
def disturb_wheels(disturbance, commands):
    """Set how the wheels turn, and the robots move, in this tick; the next call is the next tick.

    Parameters
    ----------
    disturbance : Disturbance
        `turning` and `rolling` are written.
    commands : float32 array, shape (2, 16)
        Wheel speeds asked for, rad/s.
    """
    settings, held, queue = disturbance.settings, disturbance.held, disturbance.queue
    one, half = np.float32(1.0), np.float32(0.5)
    for lane in range(LANES):
        age = disturbance.ages[lane]
        bits = random_bits(disturbance.keys[lane], age * _PER_TICK + _MOTORS)
        if uniform(bits) >= settings[LOSS, lane]:
            held[LEFT, lane], held[RIGHT, lane] = commands[LEFT, lane], commands[RIGHT, lane]
        latency = int(settings[LATENCY, lane])
        write, read = age % _SLOTS, (age - latency) % _SLOTS
        limit, noise = settings[SPEED_LIMIT, lane], settings[MOTOR_NOISE, lane]
        for wheel in range(WHEEL_ROWS):
            queue[2 * write + wheel, lane] = held[wheel, lane]
            speed = queue[2 * read + wheel, lane] if age >= latency else np.float32(0.0)
            disturbance.turning[wheel, lane] = min(max(speed, -limit), limit)
        turned_left, turned_right = (
            disturbance.turning[LEFT, lane],
            disturbance.turning[RIGHT, lane],
        )
        left = np.float32(turned_left * (one + noise * normal(bits, LEFT)))
        right = np.float32(turned_right * (one + noise * normal(bits, RIGHT)))
        mean = half * (left + right) * settings[RADIUS_SCALE, lane]
        spread = (
            half * (right - left) * settings[RADIUS_SCALE, lane] / settings[SEPARATION_SCALE, lane]
        )
        disturbance.rolling[LEFT, lane] = mean - spread
        disturbance.rolling[RIGHT, lane] = mean + spread
        disturbance.ages[lane] = age + 1


class PerturbedRobots:
    """The perturbations of the two robots of one arena.

    Parameters
    ----------
    perturbations : Perturbations
    max_wheel_speeds : sequence of two floats
        Highest wheel speeds of predator and prey, rad/s.
    """

    def __init__(self, perturbations, max_wheel_speeds):
        self._seed = perturbations.seed
        self._disturbance = make_disturbance(perturbations, max_wheel_speeds)
        self._readings = aligned_rows(READING_ROWS)
        self._commands = aligned_rows(WHEEL_ROWS)

    def starts(self, episodes=(0, 0)):
        """Return where the robots start in the episodes that `begin` takes.

        Returns
        -------
        sequence of two triples
            x and y in m, heading in rad.
        """
        if self._disturbance is None:
            return START_POSES
        return [
            start_pose(self._disturbance, lane, self._seed, np.uint64(episode))
            for lane, episode in zip(ROBOT_LANES, episodes, strict=True)
        ]

    def begin(self, episodes=(0, 0)):
        """Begin an episode.

        Parameters
        ----------
        episodes : sequence of two integers
            Numbers of predator's and prey's episode, 0 to 2**64 - 1: those of equal number are
            disturbed equally.
        """
        if self._disturbance is not None:
            for lane, episode in zip(ROBOT_LANES, episodes, strict=True):
                begin(self._disturbance, lane, self._seed, np.uint64(episode))

    def sense(self, readings):
        """Return what robots read whose true readings are these, float32 of shape (2, 37)."""
        if self._disturbance is None:
            return readings
        self._readings[:, ROBOT_LANES] = readings.T
        disturb_readings(self._disturbance, self._readings)
        return self._readings[:, ROBOT_LANES].T.copy()

    def drive(self, commands):
        """Carry out a tick's commands.

        Parameters
        ----------
        commands : array_like, shape (2, 2)
            Left and right wheel speed asked of predator and prey, rad/s.

        Returns
        -------
        turning, rolling : float32 arrays, shape (2, 2)
            Speeds of the wheels as their encoders count them, and those with which perfect robots
            would move as these do, rad/s.
        """
        if self._disturbance is None:
            exact = np.asarray(commands, dtype=np.float32)
            return exact, exact
        self._commands[:, ROBOT_LANES] = np.asarray(commands, dtype=np.float32).T
        disturb_wheels(self._disturbance, self._commands)
        turning, rolling = self._disturbance.turning, self._disturbance.rolling
        return turning[:, ROBOT_LANES].T.copy(), rolling[:, ROBOT_LANES].T.copy()

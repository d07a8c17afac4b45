"""Imperfect robots: what is drawn for them, and what it does, in Python's integers and float64."""

from dataclasses import dataclass, field

import numpy as np

RANGE = 0.1  # m, of the infrared sensors
GOLDEN, FIRST, SECOND = 0x9E3779B9, 0x21F0AAAD, 0xD35A2D97
START = np.array([(-0.5, 0, 0), (0.5, 0, np.pi)])
STEPS = np.array([2, 8, 12, 17, 21, 30, 34, 63])
SIGNED_STEPS = np.concatenate([-STEPS[::-1], STEPS])
QUATERNION = np.array([[9, 7, 5, 3], [-7, 9, -3, 5], [-5, 3, 9, -7], [-3, -5, 7, 9]])
DIRECTIONS = np.block([[QUATERNION, QUATERNION], [QUATERNION, -QUATERNION]])
DEVIATION = np.sqrt(np.sum(DIRECTIONS[0] ** 2) * np.mean(STEPS**2))
NOISE, PLACE, TURN = range(3)  # numbers of an episode
RAYS, SECTORS, GROUND_AND_WHEELS, LOSS = (0, 1, 2), 3, 4, 5  # numbers of a tick


def splitmix(key, number):
    """64 random bits."""
    bits = (key + 0x9E3779B97F4A7C15 * (number + 1)) % 2**64
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EB % 2**64
    return bits ^ (bits >> 31)


def word(key, tick, number):
    """32 random bits of a tick."""
    first = (key // 2**32 + tick * GOLDEN) % 2**32
    first = (first ^ (first >> 16)) * FIRST % 2**32
    first = (first ^ (first >> 15)) * SECOND % 2**32
    first ^= first >> 15
    second = first ^ (key % 2**32)
    second = (second ^ (second >> 16)) * FIRST % 2**32
    second ^= second >> 15
    bits = (first + number * GOLDEN) % 2**32
    bits = ((bits ^ (bits >> 16)) * FIRST + second) % 2**32
    bits = (bits ^ (bits >> 15)) * SECOND % 2**32
    return bits ^ (bits >> 15)


def normals(words):
    """Eight normal values of each word, shape (8, ...).

    The lower and then the upper halves of its bytes, the lowest byte first, choose eight steps.
    """
    chosen = np.stack([words >> shift & 15 for shift in (0, 8, 16, 24, 4, 12, 20, 28)])
    return np.tensordot(DIRECTIONS, SIGNED_STEPS[chosen], axes=1) / DEVIATION


@dataclass
class Robot:
    """One imperfect robot, 0 predator or 1 prey, in one episode against one opponent."""

    perturbations: object
    robot: int
    max_speed: float
    episode: int
    tick: int = 0
    held: np.ndarray = field(default_factory=lambda: np.zeros(2))
    queue: list = field(default_factory=list)

    def __post_init__(self):
        self.episode_key = splitmix(splitmix(self.perturbations.seed, self.episode), self.robot)
        self.key = splitmix(self.episode_key, NOISE)

    def start(self):
        """x, y and heading."""
        p = self.perturbations
        place, turn = splitmix(self.episode_key, PLACE), splitmix(self.episode_key, TURN)
        radius = p.start_displacement * np.sqrt((place >> 40) / 2**24)
        direction = 2 * np.pi * ((place >> 16) % 2**24) / 2**24
        moved = radius * np.cos(direction), radius * np.sin(direction)
        offset = (*moved, p.start_rotation * (2 * (turn >> 40) / 2**24 - 1))
        return START[self.robot] * (p.start_distance, 1, 1) + offset

    def normals(self, number):
        """The eight normal values of a number of this tick."""
        return normals(word(self.key, self.tick, number))

    def sense(self, readings):
        """The 37 readings with the noise of this tick."""
        p = self.perturbations
        numbers = (*RAYS, SECTORS, GROUND_AND_WHEELS)
        noise = np.concatenate([self.normals(number) for number in numbers])
        noisy = np.array(readings, float)
        seen = noisy[:24] <= RANGE
        noisy[:24][seen] = np.maximum(noisy[:24] + p.infrared_noise * noise[:24], 0)[seen]
        noisy[24:32] = np.clip(noisy[24:32] + p.camera_noise * noise[24:32], 0, 1)
        noisy[32:36] = np.clip(noisy[32:36] + p.ground_noise * noise[32:36], 0, 1)
        return noisy

    def drive(self, command):
        """How the wheels turn and the robot rolls in this tick, which then is over."""
        p = self.perturbations
        if (word(self.key, self.tick, LOSS) >> 9) / 2**23 >= p.command_loss:
            self.held = np.array(command, float)
        self.queue.append(self.held)
        late = len(self.queue) - 1 - p.latency_ticks
        speed = self.queue[late] if late >= 0 else np.zeros(2)
        if p.battery < 1:
            speed = np.clip(speed, -p.battery * self.max_speed, p.battery * self.max_speed)
        noise = self.normals(GROUND_AND_WHEELS)[4:6]
        rolling = speed * (1 + p.motor_noise * noise)
        self.tick += 1
        mean, spread = rolling.mean(), (rolling[1] - rolling[0]) / 2 / p.wheel_separation_scale
        return speed, p.wheel_radius_scale * np.array([mean - spread, mean + spread])

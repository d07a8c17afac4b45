"""Imperfect robots: what is drawn for them, and what it does, in Python's integers and float64."""

from dataclasses import dataclass, field

import numpy as np

RANGE = 0.1  # m, of the infrared sensors
GOLDEN, FIRST, SECOND = 0x9E3779B9, 0x21F0AAAD, 0xD35A2D97
START = np.array([(-0.5, 0, 0), (0.5, 0, np.pi)])
HADAMARD = np.array([[1, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]])
NOISE, PLACE, TURN = range(3)  # numbers of an episode
MOTORS, LOSS = 12, 14  # numbers of a tick, those before are of sensors


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


def shaped(bits, low=1.0, high=8.0):
    """A cubic of a word that is uniform in (-1, 1), with the variance 1/4 and the kurtosis 3.

    c (v + r v^3), of which r is found by bisection; moments E v^2k are 1 / (2k + 1).
    """
    for _ in range(60):
        r = (low + high) / 2
        variance = 1 / 3 + 2 * r / 5 + r**2 / 7
        fourth = 1 / 5 + 4 * r / 7 + 6 * r**2 / 9 + 4 * r**3 / 11 + r**4 / 13
        low, high = (r, high) if fourth < 3 * variance**2 else (low, r)
    v = np.array(bits, np.uint32).view(np.int32) / 2**31
    return (v + r * v**3) / np.sqrt(4 * variance)


def normals(words):
    """Four normal values from four words."""
    return HADAMARD @ shaped(words)


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

    def sense(self, readings):
        """The 37 readings with the noise of this tick."""
        p = self.perturbations
        words = [word(self.key, self.tick, number) for number in range(12)]
        noise = np.concatenate(
            [
                normals([(w << shift) % 2**32 for w in words[block : block + 4]])
                for block in (0, 4, 8)
                for shift in (0, 11, 22)
            ]
        )
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
        pair = [word(self.key, self.tick, MOTORS + i) for i in range(2)]
        noise = normals([(w << shift) % 2**32 for shift in (0, 16) for w in pair])[:2]
        rolling = speed * (1 + p.motor_noise * noise)
        self.tick += 1
        mean, spread = rolling.mean(), (rolling[1] - rolling[0]) / 2 / p.wheel_separation_scale
        return speed, p.wheel_radius_scale * np.array([mean - spread, mean + spread])

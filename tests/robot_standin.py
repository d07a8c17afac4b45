"""A robot that is not the simulator: a predator's hardware, as far as its topics tell.

It shares no code with marxbot_sim. Its body lags behind its commands, its wheels slip, it senses
at other rates than 10 Hz, late, jittering and noisily, loses messages, and has a watchdog of its
own. A prey stands still somewhere before it, in a walled square. When the robot touches
the prey, the robot says so and ends.

Usage: robot_standin.py SEED [TURN]     TURN 1: the prey stands to the left instead of to the right
"""

import math
import random
import signal
import sys

import rclpy
from geometry_msgs.msg import TwistStamped, WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

RADIUS = 0.088  # a little more than the simulated robots'
HALF = 1.5
STEP = 0.02
LAG = 0.12
LOST = 0.1
WATCHDOG = 0.7


class Standin(Node):
    """The robot, its prey and its room."""

    def __init__(self, seed, turn):
        super().__init__('base')
        self.random = random.Random(seed)
        self.x, self.y, self.heading = -0.5, 0.05, 0.1
        self.prey = (0.35, 0.35 * turn)
        self.wanted = self.actual = (0.0, 0.0)
        self.commanded = -math.inf
        self.time = 0.0
        self.pressed = False
        self.caught = False
        self.late = []
        kinds = (
            ('proximity', LaserScan, self.proximity, 0.07),
            ('camera', Camera, self.camera, 0.13),
            ('ground', Ground, self.ground, 0.05),
            ('traction', WrenchStamped, self.traction, 0.04),
        )
        self.sensors = []
        for name, kind, sense, period in kinds:
            publisher = self.create_publisher(kind, name, qos_profile_sensor_data)
            self.sensors.append([publisher, sense, period, self.random.uniform(0, period)])
        self.create_subscription(TwistStamped, 'cmd_vel', self.on_command, 1)
        self.create_timer(STEP, self.step)

    def on_command(self, command):
        if self.random.random() > LOST:
            twist = command.twist
            self.wanted, self.commanded = (twist.linear.x, twist.angular.z), self.time

    def step(self):
        self.time += STEP
        wanted = self.wanted if self.time - self.commanded < WATCHDOG else (0.0, 0.0)
        share = STEP / LAG
        self.actual = tuple(a + share * (w - a) for a, w in zip(self.actual, wanted, strict=True))
        slip = self.random.gauss(0.97, 0.03)
        distance, turn = self.actual[0] * STEP * slip, self.actual[1] * STEP * slip
        self.x += distance * math.cos(self.heading)
        self.y += distance * math.sin(self.heading)
        self.heading += turn
        limit = HALF - RADIUS
        self.pressed = max(abs(self.x), abs(self.y)) > limit
        self.x, self.y = max(-limit, min(limit, self.x)), max(-limit, min(limit, self.y))
        away = math.hypot(self.prey[0] - self.x, self.prey[1] - self.y)
        if away < 2 * RADIUS and not self.caught:
            self.caught = True
            print(f'caught after {self.time:.1f} s', flush=True)
        for sensor in self.sensors:
            publisher, sense, period, due = sensor
            if self.time >= due:
                sensor[3] = due + period * self.random.uniform(0.7, 1.3)
                message = sense()
                message.header.stamp = self.get_clock().now().to_msg()
                if self.random.random() > LOST:  # sent up to two steps late
                    self.late.append(
                        (self.time + self.random.uniform(0, 2 * STEP), publisher, message)
                    )
        for entry in [entry for entry in self.late if entry[0] <= self.time]:
            self.late.remove(entry)
            entry[1].publish(entry[2])

    def proximity(self):
        ranges = []
        for i in range(24):
            angle = self.heading + math.radians(7.5 + 15 * i)
            cosine, sine = math.cos(angle), math.sin(angle)
            hits = [math.inf]
            for direction, position in ((cosine, self.x), (sine, self.y)):
                if abs(direction) > 1e-9:
                    hits.append((math.copysign(HALF, direction) - position) / direction)
            forward = (self.prey[0] - self.x) * cosine + (self.prey[1] - self.y) * sine
            aside = (self.prey[1] - self.y) * cosine - (self.prey[0] - self.x) * sine
            if forward > 0 and abs(aside) < RADIUS:
                hits.append(forward - math.sqrt(RADIUS**2 - aside**2))
            distance = min(hits) + self.random.gauss(0, 0.004)
            ranges.append(distance if distance < RADIUS + 0.1 else math.inf)
        return LaserScan(ranges=ranges, range_min=0.05, range_max=RADIUS + 0.1)

    def camera(self):
        distance = max(math.hypot(self.prey[0] - self.x, self.prey[1] - self.y), RADIUS * 1.01)
        bearing = math.atan2(self.prey[1] - self.y, self.prey[0] - self.x) - self.heading
        half = math.asin(RADIUS / distance)
        sectors = [0.0] * 8
        for k in range(400):  # count the fan of directions that meet the prey
            direction = bearing + half * (2 * (k + 0.5) / 400 - 1)
            sectors[int(direction // (math.pi / 4)) % 8] += 2 * half / 400 / (math.pi / 4)
        noisy = [min(1.0, max(0.0, s + self.random.gauss(0, 0.02))) for s in sectors]
        return Camera(sectors=noisy)

    def ground(self):
        darkness = []
        for forward, left in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            a, b = 0.0435 * forward, 0.049 * left
            x = self.x + a * math.cos(self.heading) - b * math.sin(self.heading)
            y = self.y + a * math.sin(self.heading) + b * math.cos(self.heading)
            value = math.hypot(x, y) / (HALF * math.sqrt(2)) + self.random.gauss(0, 0.02)
            darkness.append(min(1.0, max(0.0, value)))
        return Ground(darkness=darkness)

    def traction(self):
        message = WrenchStamped()
        message.wrench.force.x = -3.0 if self.pressed else self.random.gauss(0, 0.05)
        return message


def main():
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stopped = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.append(True))
    node = Standin(int(sys.argv[1]), int(sys.argv[2]))
    while not stopped:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()

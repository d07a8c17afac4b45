"""What scripts/mujoco measures; see there."""

import argparse
import csv
import math
import subprocess
import sys
import tempfile
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import rclpy
import rclpy.executors
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from marxbot_msgs.msg import Ground
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Bool

from coevo_manager.core.episodes import trace_pair
from coevo_manager.core.episodes.numbering import episode_numbers
from coevo_manager.core.provenance import choose_environment
from marxbot_sensors import CAMERA, INFRARED, MARXBOT, TOUCH
from marxbot_sensors import GROUND as GROUND_SENSOR
from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.layout import CONTACT
from marxbot_sim.core.world import PREDATOR, PREY, World
from neuro_controller.core.champions import select_champion
from neuro_controller.core.controller import Controller
from neuro_controller.core.pilot import Pilot
from node_runner import start_ros
from robot_senses.core.lidar import infrared_ranges
from robot_senses.core.panorama import sectors

try:
    from mujoco_rover import COLUMNS, LIDAR_RANGE, RAYS, TICK, Rover
except ModuleNotFoundError as error:
    print(f'mujoco: {error}, expected it installed; see scripts/mujoco --help', file=sys.stderr)
    sys.exit(2)

ROS2 = Path(__file__).resolve().parent.parent / 'ros2'
PREDATOR_GENOME = 'shipped/open'
PREY_GENOMES = tuple(f'shipped/open:0:{rank}' for rank in (1, 2, 3, 4))
RESEND = 0.5
BODY_RADIUS = 0.09
PARAMETERS = f"""\
/**:
  ros__parameters:
    trigger: sensors
    sensor_timeout: 60.0
    contact_threshold: 0.5
    body_radius: {BODY_RADIUS}
"""


class Lockstep(Node):
    """What the rover senses as ROS topics, and the command that answers it."""

    def __init__(self):
        super().__init__('rover', namespace='/rover')
        self._command = None
        self._scan = self.create_publisher(LaserScan, 'scan', qos_profile_sensor_data)
        self._image = self.create_publisher(Image, 'image', qos_profile_sensor_data)
        self._ground = self.create_publisher(Ground, 'ground', qos_profile_sensor_data)
        self._bumper = self.create_publisher(Bool, 'bumper', 10)
        self.create_subscription(TwistStamped, 'cmd_vel', self._on_command, 10)
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(self)

    def _on_command(self, message):
        self._command = message

    def ask(self, tick, ranges, pixels, pressed, darkness=None):
        """Publish what is sensed at a tick; return linear and angular speed, m/s and rad/s."""
        nanoseconds = round((tick + 1) * TICK * 1e9)
        stamp = Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
        scan = LaserScan(
            angle_increment=2 * math.pi / RAYS,
            range_min=LIDAR_RANGE[0],
            range_max=LIDAR_RANGE[1],
            ranges=ranges.tolist(),
        )
        image = Image(height=1, width=COLUMNS, step=3 * COLUMNS, encoding='rgb8')
        image.data = pixels.tobytes()
        ground = Ground()
        scan.header.stamp = image.header.stamp = ground.header.stamp = stamp
        self._command = None
        while True:
            self._bumper.publish(Bool(data=bool(pressed)))
            self._image.publish(image)
            if darkness is not None:
                ground.darkness = darkness
                self._ground.publish(ground)
            self._scan.publish(scan)
            end = self.get_clock().now().nanoseconds + RESEND * 1e9
            while self.get_clock().now().nanoseconds < end:
                self._executor.spin_once(timeout_sec=RESEND)
                if self._command is not None and self._command.header.stamp == stamp:
                    return self._command.twist.linear.x, self._command.twist.angular.z


class Direct:
    """What the topics, the adapter and the controller node compute, without the processes.

    Parameters
    ----------
    champion : Champion
        The predator.
    """

    def __init__(self, champion):
        self._pilot = Pilot(Controller(champion.genome, **champion.settings))

    def ask(self, tick, ranges, pixels, pressed, darkness=None):
        """Return the command for what is sensed, as `Lockstep.ask`."""
        if tick == 0:
            self._pilot.reset()
        increment = float(np.float32(2 * math.pi / RAYS))
        limits = (float(np.float32(limit)) for limit in LIDAR_RANGE)
        rays = infrared_ranges(np.float32(ranges), 0.0, increment, *limits)
        readings = np.empty(MARXBOT.readings, np.float32)
        rim = np.float32(rays) - np.float32(BODY_RADIUS)
        readings[MARXBOT.rows(INFRARED)] = np.maximum(rim, 0)
        readings[MARXBOT.rows(CAMERA)] = sectors(pixels, 'green')
        readings[MARXBOT.rows(GROUND_SENSOR)] = 0.5 if darkness is None else darkness
        readings[MARXBOT.rows(TOUCH)] = pressed
        self._pilot.step(readings)
        return self._pilot.command


@contextmanager
def running(*arguments):
    """Run a command of scripts/ros2, and end it."""
    process = subprocess.Popen([ROS2, *map(str, arguments)])
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


class Chase:
    """Two champions, and episodes between them from equal starts and without noise.

    Parameters
    ----------
    champions : sequence of Champion
        Predator and prey.
    floor_sensors : bool
        Whether the rover has ground sensors.
    """

    def __init__(self, champions, floor_sensors):
        self.floor_sensors = floor_sensors
        noises = ('infrared_noise', 'camera_noise', 'ground_noise', 'motor_noise')
        self.environment, _ = choose_environment(champions, dict.fromkeys(noises, 0.0))
        self._genomes = [champion.genome for champion in champions]

    def _controller(self, robot):
        return Controller(
            self._genomes[robot],
            self.environment.max_wheel_speeds[robot],
            **self.environment.network_settings,
        )

    def starts(self, number):
        """Return where both start in an episode of that number."""
        robots = PerturbedRobots(self.environment.perturbations, self.environment.max_wheel_speeds)
        return robots.starts(episode_numbers(self._genomes[::-1], number))

    def simulated(self, number, physics):
        """Return the tick at which an episode ends in the kernel, or under other physics."""
        environment = replace(self.environment, physics=physics)
        return trace_pair(*self._genomes, environment, number).ticks

    def senseless(self, number):
        """Return that of the kernel where the predator's ground reads 0.5 everywhere."""
        world = World(self.environment.arena)
        world.reset(self.starts(number))
        controllers = [self._controller(robot) for robot in (PREDATOR, PREY)]
        for tick in range(self.environment.episode_ticks):
            readings = world.readings
            readings[PREDATOR, MARXBOT.rows(GROUND_SENSOR)] = 0.5
            wheels = [c.step(r) for c, r in zip(controllers, readings, strict=True)]
            if world.step(wheels):
                return tick + 1
        return self.environment.episode_ticks

    def with_rover(self, number, rover, driver):
        """Return that of the rover in MuJoCo, with the prey as it is in the kernel."""
        poses = list(map(list, self.starts(number)))
        rover.reset(*poses)
        world, prey = World(self.environment.arena), self._controller(PREY)
        contact = 0.0
        for tick in range(self.environment.episode_ticks):
            world.reset(poses)
            readings = world.readings[PREY]
            readings[MARXBOT.rows(TOUCH)] = contact
            darkness = rover.ground() if self.floor_sensors else None
            command = driver.ask(tick, rover.scan(), rover.panorama(), rover.pressed, darkness)
            world.step([[0, 0], prey.step(readings)])
            contact = world.bodies[PREY, CONTACT]
            poses[PREY] = world.poses[PREY].astype(float).tolist()
            if rover.step(*command, poses[PREY]):
                return tick + 1
            poses[PREDATOR] = list(rover.pose)
        return self.environment.episode_ticks


@contextmanager
def over_topics(floor_sensors):
    """Start adapter and controller, and yield a `Lockstep` with them."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / 'rover.yaml').write_text(PARAMETERS)
        export = ['run', 'coevo_manager', 'export', PREDATOR_GENOME, '--species', 'predator']
        subprocess.run([ROS2, *export, '--yaml', folder / 'predator.yaml'], check=True)
        stack.enter_context(
            running(
                *('run', 'robot_senses', 'adapter', '--ros-args', '-r', '__ns:=/rover'),
                *('-p', f'resting_ground:={str(not floor_sensors).lower()}'),
            )
        )
        stack.enter_context(
            running(
                *('launch', 'neuro_controller', 'hardware.launch.xml', 'robot:=rover'),
                f'genome:={folder / "predator.yaml"}',
                f'parameters:={folder / "rover.yaml"}',
                'autostart:=true',
            )
        )
        start_ros(['mujoco'])
        stack.callback(rclpy.try_shutdown)
        lockstep = Lockstep()
        stack.callback(lockstep.destroy_node)
        yield lockstep


def interval(values):
    """Return a mean and its 95 % interval by the bootstrap."""
    means = np.random.default_rng(0).choice(values, (10_000, len(values))).mean(axis=1)
    return np.mean(values), *np.quantile(means, (0.025, 0.975))


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(prog='mujoco')
    parser.add_argument('--episodes', type=int, default=40)
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--floor-sensors', action='store_true')
    parser.add_argument('--direct', action='store_true')
    parser.add_argument('--csv', type=Path)
    options = parser.parse_args()
    predator = select_champion(PREDATOR_GENOME, 'predator')
    chases = [
        Chase([predator, select_champion(prey, 'prey')], options.floor_sensors)
        for prey in PREY_GENOMES
    ]
    episode_ticks = chases[0].environment.episode_ticks
    rows = []
    route = nullcontext(Direct(predator)) if options.direct else over_topics(options.floor_sensors)
    rover = Rover()
    with route as driver:
        for number in range(options.first, options.first + options.episodes):
            chase = chases[number % len(chases)]
            row = {
                'episode': number,
                'kernel': chase.simulated(number, 'kinematic'),
                'pymunk': chase.simulated(number, 'pymunk'),
                'no ground': chase.senseless(number),
                'rover': chase.with_rover(number, rover, driver),
            }
            rows.append(row)
            print(row, flush=True)
    if options.csv:
        with options.csv.open('w', newline='') as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    for name in list(rows[0])[1:]:
        mean, low, high = interval([1 - row[name] / episode_ticks for row in rows])
        print(f'{name:10} {mean:.3f} ({low:.3f} to {high:.3f})')
    return 0


if __name__ == '__main__':
    sys.exit(main())

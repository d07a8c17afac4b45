"""The simulator node: two MarxBots in an arena, in real time or in lockstep with their control."""

import sys
import time
from pathlib import Path

import numpy as np
from ament_index_python.packages import get_package_share_directory
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from marxbot_msgs.msg import ArenaState
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from marxbot_sim.commands import Commands
from marxbot_sim.core.parameters import ROBOTS, TICK, Arena
from marxbot_sim.core.simulation import Simulation
from marxbot_sim.interface import ARENA, SERVICES, SIMULATOR
from marxbot_sim.markers import ArenaMarkers
from marxbot_sim.monitor import Monitor
from marxbot_sim.node_parameters import Parameters
from marxbot_sim.robot_topics import RobotTopics
from marxbot_sim.transforms import Transforms
from node_runner import Complaints, Concerns, run_node

RESEND_PERIOD = 1.0
"""In lockstep, how long to wait for a command before readings are published again, s of real
time."""

MAX_STEPS = 1_000_000
"""Most ticks that one step request may ask for."""


class Simulator(Node):
    """Wraps `Simulation` in topics, services and a pace; the package's README lists them all."""

    def __init__(self):
        super().__init__('simulator')
        parameters = self._settings = Parameters(self, self._set_pace, self._perturb, self._number)
        self._complaints = Complaints(self.get_logger())
        self._lockstep = parameters['lockstep']
        self._paused = parameters['paused']
        self._steps_left = 0
        Simulation().step(np.zeros((2, 2)))  # compiled now, not at the first tick
        self._simulation = Simulation(
            parameters.group('arena'),
            parameters['physics'],
            parameters.group('perturbations'),
            parameters['max_wheel_speed'],
        )

        share = Path(get_package_share_directory('marxbot_sim'))
        description = (share / 'urdf' / 'marxbot.urdf').read_text(encoding='utf-8')
        publishers = {
            topic.name: self.create_publisher(topic.type, topic.name, topic.qos)
            for topic in ARENA
            if not topic.name.startswith('/tf')
        }
        self._clock_publisher = publishers['/clock']
        self._state_publisher = publishers['arena/state']
        self._markers_publisher = publishers['arena/markers']
        self._robots = [
            RobotTopics(self, robot, description, parameters['reliable_sensors'])
            for robot in ROBOTS
        ]
        self._transforms = Transforms(self, dict.fromkeys(ROBOTS, description))
        self._markers = ArenaMarkers()
        self._commands = Commands(self, parameters, self._complaints.warn, self._advance_lockstep)
        self._last_step = 0, None
        for service in SERVICES:
            answer = getattr(self, f'_on_{service.name.removeprefix("~/")}')
            self.create_service(service.type, service.name, answer)

        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._pace_timer = None
        self._set_pace(parameters['real_time_factor'])
        self._monitor = Monitor(self, publishers['/diagnostics'])
        self._begin()
        arena = self._simulation.arena
        self.get_logger().info(
            f'arena of {arena.size:g} m, {"obstacle" if arena.obstacle else "open"}, '
            f'{parameters["physics"]} physics, {self._pace}{", paused" if self._paused else ""}'
        )
        self._concerns = Concerns(self)

    def _set_pace(self, real_time_factor):
        if self._pace_timer is not None:
            self.destroy_timer(self._pace_timer)
        if self._lockstep:
            self._pace = 'lockstep'
            self._pace_timer = self.create_timer(RESEND_PERIOD, self._resend, clock=self._steady)
        else:
            self._pace = f'{real_time_factor:g} x real time'
            period = TICK / real_time_factor
            self._pace_timer = self.create_timer(period, self._on_timer, clock=self._steady)

    def _perturb(self, perturbations):
        self._simulation.perturb(perturbations)

    def _number(self, numbers):
        self._simulation.numbers = numbers

    # Ticks

    @property
    def _running(self):
        return not self._ended and (not self._paused or self._steps_left > 0)

    def _begin(self):
        """Publish the state of an episode that has just been reset."""
        self._ended = False
        self._commands.begin()
        self._sensors_published = False
        self._publish_clock()
        self._publish_state()
        self._go_on()

    def _go_on(self):
        """After a reset, a pause or a step request: publish the readings, if the clock runs."""
        if self._running and not self._sensors_published:
            self._publish_sensors()
        self._advance_lockstep()

    def _advance_lockstep(self):
        ready = self._running and self._sensors_published and not self._commands.missing
        if self._lockstep and ready:
            self._tick()

    def _on_timer(self):
        if self._running:
            self._commands.stop_silent()
            self._tick()

    def _tick(self):
        captured = self._simulation.step(self._commands.wheels)
        self._monitor.ticked()
        self._steps_left = max(0, self._steps_left - 1)
        self._sensors_published = False
        self._ended = captured or self._simulation.tick == self._settings['episode_ticks']
        self._publish_clock()
        if self._running:
            self._publish_sensors()
        self._publish_state()
        if self._ended:
            what = 'prey captured' if captured else 'episode over'
            self.get_logger().info(f'{what} at tick {self._simulation.tick}')
            if self._settings['at_end'] == 'reset':
                self._simulation.reset()
                self._begin()

    def _resend(self):
        """In lockstep: publish readings again that a controller missed or came too late for."""
        if self._running and time.monotonic() - self._published_at > RESEND_PERIOD:
            missing = ' and '.join(self._commands.missing)
            self._complaints.warn(
                f'lockstep: tick {self._simulation.tick} waits for a command of {missing}'
            )
            self._publish_sensors()

    # Topics

    def _publish_clock(self):
        self.stamp = _stamp(self._simulation.tick)
        self._clock_publisher.publish(ClockMessage(clock=self.stamp))

    def _publish_sensors(self):
        if not self._sensors_published:
            self._commands.expect(self.stamp)
        self._sensors_published = True
        self._published_at = time.monotonic()
        readings, forces = self._simulation.readings, self._simulation.contact_forces
        for robot, reading, force in zip(self._robots, readings, forces, strict=True):
            robot.publish_sensors(self.stamp, reading, force)

    def _publish_state(self):
        simulation = self._simulation
        poses = simulation.poses
        for number, robot in enumerate(self._robots):
            robot.publish_state(
                self.stamp,
                poses[number],
                simulation.odometry[number],
                simulation.wheels[number],
                simulation.tick,
            )
        self._transforms.publish(
            self.stamp,
            poses,
            [odometry.pose for odometry in simulation.odometry],
            [robot.wheel_angles for robot in self._robots],
        )
        if self._markers_publisher.get_subscription_count():
            self._markers_publisher.publish(
                self._markers.message(self.stamp, simulation.arena, poses, simulation.readings)
            )
        self._publish_arena_state()

    def _publish_arena_state(self):
        simulation = self._simulation
        message = ArenaState(
            episode=simulation.episode,
            tick=simulation.tick,
            captured=simulation.captured,
            ended=self._ended,
            paused=not self._running,
            size=simulation.arena.size,
            obstacle=simulation.arena.obstacle,
        )
        message.header.stamp = self.stamp
        message.header.frame_id = 'map'
        self._state_publisher.publish(message)

    def status(self):
        """Return level, sentence and values for /diagnostics."""
        simulation = self._simulation
        level, text = DiagnosticStatus.OK, 'running'
        if not self._running:
            text = 'episode over' if self._ended else 'paused'
        elif self._lockstep and time.monotonic() - self._published_at > RESEND_PERIOD:
            level, text = DiagnosticStatus.WARN, 'lockstep waits for a command'
        if self._concerns.sentences:
            level, text = DiagnosticStatus.WARN, '; '.join([text, *self._concerns.sentences])
        values = {
            'physics': self._settings['physics'],
            'pace': self._pace,
            'episode': str(simulation.episode),
            'tick': str(simulation.tick),
            'captured': str(simulation.captured),
        }
        for robot, count in zip(ROBOTS, self._commands.refused, strict=True):
            values[f'refused commands of {robot}'] = str(count)
        return level, text, values

    # Services

    def _on_reset(self, _, response):
        return self._restart(response, self._simulation.reset)

    def _on_set_poses(self, request, response):
        poses = [(pose.x, pose.y, pose.theta) for pose in (request.predator, request.prey)]
        return self._restart(response, lambda: self._simulation.reset(poses))

    def _on_set_arena(self, request, response):
        def rebuild():
            self._simulation.rebuild(
                Arena(request.size, request.obstacle, request.wall_friction, request.wall_contact)
            )

        return self._restart(response, rebuild)

    def _restart(self, response, restart):
        try:
            restart()
        except ValueError as error:
            response.message = str(error)
            return response
        self._begin()
        response.success = True
        response.message = f'episode {self._simulation.episode} begins'
        return response

    def _on_pause(self, request, response):
        self._paused = request.data
        self._steps_left = 0
        self._go_on()
        self._publish_arena_state()
        response.success = True
        response.message = 'paused' if self._paused else 'running'
        return response

    def _on_step(self, request, response):
        if request.number and request.number == self._last_step[0]:
            return self._last_step[1]
        self._last_step = request.number, response
        response.tick = self._simulation.tick
        if not self._paused:
            response.message = 'the simulator is running, expected it to be paused first'
        elif self._ended:
            response.message = 'the episode is over, expected a reset first'
        elif not 1 <= request.ticks <= MAX_STEPS:
            response.message = f'ticks is {request.ticks}, expected 1 to {MAX_STEPS}'
        else:
            response.success = True
            response.tick += request.ticks
            self._steps_left = request.ticks
            self._go_on()
        return response


def _stamp(tick):
    """Return the time of a tick. An episode starts at one tick: zero means no time in ROS."""
    nanoseconds = (tick + 1) * round(TICK * 1e9)
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def main():
    """Run the node until it is stopped."""
    return run_node(Simulator, SIMULATOR)


if __name__ == '__main__':
    sys.exit(main())

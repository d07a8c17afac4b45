"""The simulator node: two MarxBots in an arena, in real time or in lockstep with their controllers."""

import math
import sys
import time
from dataclasses import fields
from pathlib import Path

import numpy as np
from ament_index_python.packages import get_package_share_directory
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from marxbot_msgs.msg import ArenaState
from marxbot_msgs.srv import SetArena, SetPoses, Step
from node_runner import run_node
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from marxbot_sim.core.drive import wheel_speeds
from marxbot_sim.core.parameters import TICK, Arena
from marxbot_sim.core.perturbations import Perturbations
from marxbot_sim.core.simulation import ROBOTS, Simulation
from marxbot_sim.markers import ArenaMarkers
from marxbot_sim.monitor import Monitor
from marxbot_sim.robot_topics import RobotTopics
from marxbot_sim.transforms import Transforms

RESEND_PERIOD = 1.0
"""In lockstep, how long to wait for a command before the readings are published again, s (real time)."""

LOG_PERIOD = 5.0
"""Shortest time between two equal complaints in the log, s."""

MAX_STEPS = 1_000_000
"""Most ticks that one step request may ask for."""

AT_END = ('pause', 'reset')
"""What the simulator may do when an episode ends."""

_STATE_QOS = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_PARAMETERS = {
    'physics': ('kinematic', "'kinematic' (exact motion, compiled) or 'pymunk' (rigid bodies)"),
    'lockstep': (False, 'make a tick when both robots have got their command, and only then'),
    'real_time_factor': (1.0, 'simulated over real time; not in lockstep; can be set while running'),
    'paused': (False, 'start paused'),
    'episode_ticks': (0, 'ticks of 0.1 s after which an episode ends; 0: only a capture ends it'),
    'at_end': ('pause', "what to do when an episode ends: 'pause', or 'reset' to start the next"),
    'stamped_cmd_vel': (False, 'take TwistStamped on cmd_vel instead of Twist'),
    'cmd_vel_timeout': (0.5, 's of simulated time without a command after which a robot is stopped'),
    'max_wheel_speed': (10.0, 'fastest a wheel can turn, rad/s; commands above it are slowed down'),
}


class Simulator(Node):
    """Wraps `Simulation` in topics, services and a pace; see the package's README for all of them."""

    def __init__(self):
        super().__init__('simulator')
        self._declare_parameters()
        self._simulation = Simulation(
            Arena(**self._group('arena', Arena)),
            self._value('physics'),
            Perturbations(**self._group('perturbations', Perturbations)),
            self._value('max_wheel_speed'),
        )
        self._lockstep = self._value('lockstep')
        self._stamped = self._value('stamped_cmd_vel')
        self._paused = self._value('paused')
        self._steps_left = 0
        self._ended = False

        share = Path(get_package_share_directory('marxbot_sim'))
        description = (share / 'urdf' / 'marxbot.urdf').read_text(encoding='utf-8')
        self._clock_publisher = self.create_publisher(ClockMessage, '/clock', 100)
        self._state_publisher = self.create_publisher(ArenaState, 'arena/state', _STATE_QOS)
        self._markers_publisher = self.create_publisher(MarkerArray, 'arena/markers', 100)
        self._robots = [RobotTopics(self, robot, description) for robot in ROBOTS]
        self._transforms = Transforms(self)
        self._markers = ArenaMarkers()
        self._monitor = Monitor(self)

        command_type = TwistStamped if self._stamped else Twist
        for number, robot in enumerate(ROBOTS):
            self.create_subscription(
                command_type,
                f'{robot}/cmd_vel',
                lambda message, number=number: self._on_command(number, message),
                10,
            )
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(SetBool, '~/pause', self._on_pause)
        self.create_service(Step, '~/step', self._on_step)
        self.create_service(SetPoses, '~/set_poses', self._on_set_poses)
        self.create_service(SetArena, '~/set_arena', self._on_set_arena)

        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = None
        self.add_on_set_parameters_callback(self._on_set_parameters)
        self._set_pace(self._value('real_time_factor'))
        self._begin()
        pace = 'lockstep' if self._lockstep else f'{self._value("real_time_factor"):g} x real time'
        self.get_logger().info(
            f'arena of {self._simulation.arena.size:g} m, '
            f'{"obstacle" if self._simulation.arena.obstacle else "open"}, {self._value("physics")} physics, '
            f'{pace}{", paused" if self._paused else ""}'
        )

    # Parameters

    def _declare_parameters(self):
        live = ('real_time_factor',)
        for name, (default, text) in _PARAMETERS.items():
            self.declare_parameter(
                name, default, ParameterDescriptor(description=text, read_only=name not in live)
            )
        for group, kind in (('arena', Arena), ('perturbations', Perturbations)):
            for field in fields(kind):
                self.declare_parameter(
                    f'{group}.{field.name}',
                    field.default,
                    ParameterDescriptor(description=f'see {kind.__name__}', read_only=group == 'arena'),
                )
        if self._value('at_end') not in AT_END:
            raise ValueError(f'at_end is {self._value("at_end")!r}, expected one of {", ".join(AT_END)}')
        if self._value('episode_ticks') < 0:
            raise ValueError(f'episode_ticks is {self._value("episode_ticks")}, expected 0 or more')
        for name in ('real_time_factor', 'cmd_vel_timeout', 'max_wheel_speed'):
            _check_positive(name, self._value(name))

    def _value(self, name):
        return self.get_parameter(name).value

    def _group(self, group, kind):
        return {field.name: self._value(f'{group}.{field.name}') for field in fields(kind)}

    def _on_set_parameters(self, parameters):
        """Take a new pace or new perturbations, all or nothing."""
        perturbations = self._group('perturbations', Perturbations)
        factor = None
        try:
            for parameter in parameters:
                group, _, name = parameter.name.partition('.')
                if group == 'perturbations':
                    perturbations[name] = parameter.value
                elif parameter.name == 'real_time_factor':
                    factor = parameter.value
                    _check_positive('real_time_factor', factor)
            perturbations = Perturbations(**perturbations)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if any(parameter.name.startswith('perturbations.') for parameter in parameters):
            self._simulation.perturb(perturbations)
        if factor is not None:
            self._set_pace(factor)
        return SetParametersResult(successful=True)

    def _set_pace(self, real_time_factor):
        if self._timer is not None:
            self.destroy_timer(self._timer)
        if self._lockstep:
            self._timer = self.create_timer(RESEND_PERIOD, self._resend, clock=self._steady)
        else:
            self._timer = self.create_timer(TICK / real_time_factor, self._on_timer, clock=self._steady)

    # Commands

    def _on_command(self, number, message):
        """Take a robot's command; in lockstep, only the first that answers the present readings."""
        if self._stamped:
            stamp, twist = message.header.stamp, message.twist
        else:
            stamp, twist = None, message
        if self._lockstep:
            if not self._sensors_published or number in self._answered:
                return
            if stamp is not None and stamp != self.stamp:
                self._warn(f'{ROBOTS[number]}: ignored a command that answers other readings than the present')
                return
        try:
            wheels, limited = wheel_speeds(twist.linear.x, twist.angular.z, self._value('max_wheel_speed'))
        except ValueError as error:
            wheels, limited = np.zeros(2, np.float32), False
            self._monitor.refused(number)
            self._warn(f'{ROBOTS[number]} stopped: cmd_vel {error}')
        if limited:
            self._warn(
                f'{ROBOTS[number]} slowed down: cmd_vel asks {twist.linear.x:g} m/s and {twist.angular.z:g} rad/s, '
                f'more than wheels of {self._value("max_wheel_speed"):g} rad/s can do'
            )
        self._commands[number] = wheels
        self._command_ticks[number] = self._simulation.tick
        self._answered.add(number)
        if self._lockstep:
            self._advance_lockstep()

    def _stop_silent_robots(self):
        limit = self._value('cmd_vel_timeout') / TICK
        for number, robot in enumerate(ROBOTS):
            age = self._simulation.tick - self._command_ticks[number]
            if age > limit and self._commands[number].any():
                self._commands[number] = np.zeros(2, np.float32)
                self._warn(f'{robot} stopped: no cmd_vel for {age * TICK:.1f} s')

    # Ticks

    @property
    def _running(self):
        return not self._ended and (not self._paused or self._steps_left > 0)

    def _begin(self):
        """Publish the state of an episode that has just been reset."""
        self._ended = False
        self._commands = np.zeros((2, 2), np.float32)
        self._command_ticks = [0, 0]
        self._sensors_published = False
        self._answered = set()
        self._publish_clock()
        self._publish_state()
        self._go_on()

    def _go_on(self):
        """After a reset, a pause or a step request: publish the readings, if the simulator runs."""
        if self._running and not self._sensors_published:
            self._publish_sensors()
        if self._lockstep:
            self._advance_lockstep()

    def _advance_lockstep(self):
        if self._running and self._sensors_published and len(self._answered) == len(ROBOTS):
            self._tick()

    def _on_timer(self):
        if self._running:
            self._stop_silent_robots()
            self._tick()

    def _tick(self):
        captured = self._simulation.step(self._commands)
        self._monitor.ticked()
        self._steps_left = max(0, self._steps_left - 1)
        self._sensors_published = False
        self._answered.clear()
        episode_ticks = self._value('episode_ticks')
        self._ended = captured or 0 < episode_ticks <= self._simulation.tick
        self._publish_clock()
        if self._running:
            self._publish_sensors()
        self._publish_state()
        if self._ended:
            what = 'prey captured' if captured else 'episode over'
            self.get_logger().info(f'{what} at tick {self._simulation.tick}')
            if self._value('at_end') == 'reset':
                self._simulation.reset()
                self._begin()

    def _publish_clock(self):
        self.stamp = _stamp(self._simulation.tick)
        self._clock_publisher.publish(ClockMessage(clock=self.stamp))

    def _publish_sensors(self):
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
                self.stamp, poses[number], simulation.odometry[number], simulation.wheels[number], simulation.tick
            )
        self._transforms.publish(self.stamp, self._robots, poses, simulation.odometry)
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

    def _resend(self):
        """In lockstep: publish readings again that a controller has missed or has come too late for."""
        if not self._running or time.monotonic() - self._published_at < RESEND_PERIOD:
            return
        missing = ' and '.join(robot for number, robot in enumerate(ROBOTS) if number not in self._answered)
        self._warn(f'lockstep: tick {self._simulation.tick} waits for the command of {missing}')
        self._publish_sensors()

    def status(self):
        """Return level, sentence and values for /diagnostics."""
        simulation = self._simulation
        level, message = DiagnosticStatus.OK, 'running'
        if not self._running:
            message = 'episode over' if self._ended else 'paused'
        elif self._lockstep and time.monotonic() - self._published_at > RESEND_PERIOD:
            level, message = DiagnosticStatus.WARN, 'lockstep waits for a command'
        values = {
            'physics': self._value('physics'),
            'pace': 'lockstep' if self._lockstep else f'{self._value("real_time_factor"):g} x real time',
            'episode': str(simulation.episode),
            'tick': str(simulation.tick),
            'captured': str(simulation.captured),
        }
        return level, message, values

    def _warn(self, text):
        self.get_logger().warning(text, throttle_duration_sec=LOG_PERIOD)

    # Services

    def _on_reset(self, _, response):
        self._simulation.reset()
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
        response.tick = self._simulation.tick
        if not self._paused:
            response.message = 'the simulator is running, expected it to be paused first'
        elif self._ended:
            response.message = 'the episode is over, expected a reset first'
        elif not 1 <= request.ticks <= MAX_STEPS:
            response.message = f'ticks is {request.ticks}, expected 1 to {MAX_STEPS}'
        else:
            self._steps_left = request.ticks
            response.success = True
            response.tick += request.ticks
            self._go_on()
        return response

    def _on_set_poses(self, request, response):
        poses = [(pose.x, pose.y, pose.theta) for pose in (request.predator, request.prey)]
        return self._restart(response, lambda: self._simulation.reset(poses))

    def _on_set_arena(self, request, response):
        return self._restart(
            response,
            lambda: self._simulation.rebuild(
                Arena(request.size, request.obstacle, request.wall_friction)
            ),
        )

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


def _check_positive(name, value):
    if not 0 < value < math.inf:
        raise ValueError(f'{name} is {value}, expected a finite number above 0')


def _stamp(tick):
    """Return the time of a tick. An episode starts at one tick, since zero means no time in ROS."""
    nanoseconds = (tick + 1) * round(TICK * 1e9)
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def main():
    """Run the node until it is stopped."""
    return run_node(Simulator)


if __name__ == '__main__':
    sys.exit(main())

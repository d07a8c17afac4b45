"""When something is wrong with a robot or with its controller, it stands still and is told why."""

import sys

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped, WrenchStamped
from lifecycle_msgs.srv import GetState
from marxbot_msgs.msg import Camera, Ground
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from marxbot_sensors import MARXBOT
from neuro_controller.core.champions import SHIPPED
from neuro_controller.core.snapshot import read_snapshot
from neuro_controller.interface import NETWORK
from neuro_controller.sensors import Sensors

SENSORS = [sensor.topic for sensor in MARXBOT.sensors]

TYPES = {
    'proximity': LaserScan,
    'camera': Camera,
    'ground': Ground,
    'traction': WrenchStamped,
}
SECOND = 10**9


class Robot:
    """A controller that is driving, by what its sensors say, and what it commands."""

    def __init__(self, starter, client, tmp_path, namespace, *parameters):
        self.client, self.namespace = client, namespace
        genome = read_snapshot(SHIPPED / 'open.npz').best('predator', 1)[0]
        file = tmp_path / 'genome.yaml'
        genes = ', '.join(map(repr, map(float, genome)))
        file.write_text(f'/**:\n  ros__parameters:\n    genome: [{genes}]\n')
        options = ['autostart:=true', 'trigger:=sensors', *parameters]
        arguments = ['-r', f'__ns:={namespace}', '--params-file', file]
        arguments += [part for option in options for part in ('-p', option)]
        self.process = starter(['neuro_controller', 'controller', '--ros-args', *arguments])
        self.process.wait_for_output('active')
        self.commands = client.listen(TwistStamped, f'{namespace}/cmd_vel')
        self.reports = client.listen(DiagnosticArray, '/diagnostics')
        self.publishers = {
            name: client.publisher(kind, f'{namespace}/{name}', qos_profile_sensor_data)
            for name, kind in TYPES.items()
        }
        self.turn = 0

    def send(self, stamps):
        """Send readings that differ from the last ones; stamps, ns, in the order of SENSORS."""
        self.turn += 1
        for name, stamp in zip(SENSORS, stamps, strict=True):
            message = TYPES[name]()
            if name == 'proximity':
                message.ranges = [float('inf')] * 23 + [0.1 + 0.001 * (self.turn % 50)]
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, SECOND)
            self.publishers[name].publish(message)

    def statuses(self):
        """The reports of this controller."""
        name = f'{self.namespace.lstrip("/")}/controller: network'
        return [s for report in self.reports for s in report.status if s.name == name]

    def status(self):
        """The last of them, or None."""
        return (self.statuses() or [None])[-1]

    def drives(self):
        return [c for c in self.commands if c.twist.linear.x or c.twist.angular.z]

    def stopped(self, reason):
        """Whether the last command is a stop and /diagnostics says why."""
        status = self.status()
        last = self.commands[-1].twist if self.commands else None
        return (
            last is not None
            and (last.linear.x, last.angular.z) == (0, 0)
            and status is not None
            and status.level == DiagnosticStatus.ERROR
            and reason in status.message
        )


@pytest.fixture(scope='module')
def robot(starter, client, tmp_path_factory):
    return Robot(starter, client, tmp_path_factory.mktemp('robot'), '/robot')


def drive(robot, stamps, commands=5):
    """Send sets of readings until the controller has commanded some motion."""
    robot.commands.clear()
    turn = iter(range(10_000))

    def driven():
        robot.send(stamps(next(turn)))
        return len(robot.drives()) >= commands

    robot.client.until(driven, 'commands')


def test_readings_whose_stamps_differ_by_milliseconds_are_answered(robot):
    drive(robot, lambda turn: [(100 + turn) * SECOND // 10 + i * 3_000_000 for i in range(4)])


def test_readings_without_stamps_are_answered(robot):
    drive(robot, lambda turn: [0] * 4)
    assert robot.drives()[-1].header.stamp.sec > 1_000_000


def test_stamps_too_far_apart_stop_the_robot_and_are_told(robot):
    drive(robot, lambda turn: [(1000 + turn) * SECOND] * 4)
    turn = iter(range(10_000))

    def stopped():
        now = (5000 + next(turn)) * SECOND
        robot.send([now, now, now, now - SECOND])
        return robot.stopped('their stamps differ by 1 s, more than stamp_tolerance, 0.05 s')

    robot.client.until(stopped, 'the stop')
    assert 'no complete set of readings for 0.5 s' in robot.process.stderr_text


def test_stamps_that_stand_still_stop_the_robot_and_are_told(robot):
    drive(robot, lambda turn: [(10_000 + turn) * SECOND] * 4)

    def stopped():
        robot.send([9 * SECOND] * 4)
        return robot.stopped('the stamps of readings do not advance')

    def reported_twice():
        robot.send([9 * SECOND] * 4)
        return len(robot.statuses()) >= 2

    robot.client.until(stopped, 'the stop')
    robot.reports.clear()
    robot.client.until(reported_twice, 'two more reports')
    assert all('do not advance' in status.message for status in robot.statuses())
    drive(robot, lambda turn: [(20_000 + turn) * SECOND] * 4)


def test_a_request_of_an_unknown_type_is_refused_and_the_node_lives(robot):
    parameter = Parameter(name='max_wheel_speed', value=ParameterValue(type=77))
    service = f'{robot.namespace}/controller/set_parameters'
    parameters = [parameter, parameter]
    results = robot.client.call(SetParameters, service, parameters=parameters).results
    assert [result.successful for result in results] == [False, False]
    assert '77' in results[0].reason
    result = robot.client.call(
        SetParametersAtomically, f'{service}_atomically', parameters=[parameter]
    ).result
    assert not result.successful and '77' in result.reason
    assert 'a callback failed with ValueError' in robot.process.stderr_text
    drive(robot, lambda turn: [(30_000 + turn) * SECOND] * 4)


@pytest.mark.parametrize('kind', range(10))
def test_no_type_of_value_breaks_it(robot, kind):
    names = ('genome', 'max_wheel_speed', 'motor_map', 'limits.linear_speed', 'nothing')
    parameters = [Parameter(name=name, value=ParameterValue(type=kind)) for name in names]
    service = f'{robot.namespace}/controller/set_parameters'
    results = robot.client.call(SetParameters, service, parameters=parameters).results
    assert not any(result.successful for result in results)


def test_a_twist_where_twist_stamped_is_due_is_told(robot, starter):
    program = (
        'import rclpy; from rclpy.node import Node; from geometry_msgs.msg import Twist; '
        "rclpy.init(); node = Node('base'); "
        f"node.create_subscription(Twist, '{robot.namespace}/cmd_vel', print, 10); "
        'rclpy.spin(node)'
    )
    starter([sys.executable, '-c', program])
    sentence = (
        '/robot/cmd_vel is geometry_msgs/msg/TwistStamped here, and taken as '
        'geometry_msgs/msg/Twist by another node'
    )
    robot.process.wait_for_output(sentence)
    drive(robot, lambda turn: [(40_000 + turn) * SECOND] * 4)
    robot.client.until(lambda: sentence in robot.status().message, 'the report')


@pytest.mark.parametrize(('kind', 'value'), [('int', '5'), ('bool', 'true'), ('text', 'x')])
def test_a_champion_that_is_no_genome_is_told_and_the_node_lives(starter, client, kind, value):
    namespace = f'/lost_{kind}'
    program = (
        'import sys, rclpy; from rclpy.node import Node; rclpy.init(args=sys.argv); '
        f"node = Node('holder', namespace='{namespace}', "
        'automatically_declare_parameters_from_overrides=True); rclpy.spin(node)'
    )
    held = [f'a:={value}', *(f'a.{parameter.name}:={parameter.default}' for parameter in NETWORK)]
    options = [part for parameter in held for part in ('-p', parameter)]
    starter([sys.executable, '-c', program, '--ros-args', *options])
    options = [f'genome_server:={namespace}/holder', 'champion:=a', 'autostart:=true']
    arguments = ['-r', f'__ns:={namespace}']
    arguments += [part for option in options for part in ('-p', option)]
    process = starter(['neuro_controller', 'controller', '--ros-args', *arguments])
    process.wait_for_output(f"'a' of {namespace}/holder is")
    assert 'expected a genome' in process.stderr_text
    state = client.call(GetState, f'{namespace}/controller/get_state').current_state
    assert state.label == 'unconfigured'
    assert process.poll() is None


def message(sensor, stamp):
    made = TYPES[sensor]()
    if sensor == 'proximity':
        made.ranges = [1.0] * 24
    made.header.stamp.sec, made.header.stamp.nanosec = divmod(stamp, SECOND)
    return made


def test_a_set_takes_one_new_message_of_each_sensor():
    sensors = Sensors(0.5, 0.085, 0.05)
    for sensor, stamp in zip(SENSORS, (0, 20, 40, 45), strict=True):
        assert sensors.complete_set() is None
        sensors.take(sensor, message(sensor, SECOND + stamp * 10**6), 0.0, 7)
    assert sensors.complete_set() == SECOND + 45 * 10**6
    assert sensors.complete_set() is None
    assert 'no new proximity and no new camera' in sensors.why_incomplete()
    for sensor in SENSORS:
        sensors.take(sensor, message(sensor, 0), 0.0, 12 * SECOND)
    assert sensors.complete_set() == 12 * SECOND


def test_ranges_become_the_distances_from_the_rim_exactly():
    radius, rng = np.float32(0.085), np.random.default_rng(1)
    distances = (rng.random(24).astype(np.float32) * np.float32(0.1) + radius) - radius
    sensors = Sensors(0.5, 0.085, 0.05)
    scan = message('proximity', SECOND)
    scan.ranges = (distances + radius).tolist()
    sensors.take('proximity', scan, 0.0, 0)
    assert sensors.readings[:24].tobytes() == distances.tobytes()

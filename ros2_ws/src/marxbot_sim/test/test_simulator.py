"""The simulator node as a process: topics, lockstep, services, and everything thrown at it."""

import math
import signal

import numpy as np
import pytest
from geometry_msgs.msg import Pose2D, Twist, TwistStamped, WrenchStamped
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from marxbot_msgs.msg import ArenaState, Camera, Ground
from marxbot_msgs.srv import SetArena, SetPoses, Step
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.qos import ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import ColorRGBA, String
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from marxbot_sim.core.drive import body_speeds, wheel_speeds
from marxbot_sim.core.parameters import Arena
from marxbot_sim.core.world import World

ROBOTS = ('predator', 'prey')
RADIUS = np.float32(0.085)


@pytest.fixture(scope='module')
def lockstep(starter, client):
    """A paused simulator in lockstep in the namespace /a, and its topics."""
    process = starter(simulator('/a', 'lockstep:=true', 'paused:=true'))
    return Arm(client, '/a', process, TwistStamped)


def simulator(namespace, *parameters):
    """Command line of a simulator in a namespace, its clock included."""
    settings = [part for parameter in parameters for part in ('-p', parameter)]
    remaps = ['-r', f'__ns:={namespace}', '-r', f'/clock:={namespace}/clock']
    return ['marxbot_sim', 'simulator', '--ros-args', *remaps, *settings]


class Arm:
    """What a test needs of one simulator: its state, its truth, commands and services."""

    def __init__(self, client, namespace, process, command_type):
        self.client, self.namespace, self.process = client, namespace, process
        self.command_type = command_type
        self.states = client.listen(ArenaState, f'{namespace}/arena/state')
        self.scans, self.truth, self.publishers, self.readings = [], [], [], []
        for robot in ROBOTS:
            topic = f'{namespace}/{robot}'
            self.truth.append(client.listen(Odometry, f'{topic}/ground_truth'))
            self.readings.append(
                [
                    client.listen(kind, f'{topic}/{name}', qos_profile_sensor_data)
                    for kind, name in (
                        (LaserScan, 'proximity'),
                        (Camera, 'camera'),
                        (Ground, 'ground'),
                        (WrenchStamped, 'traction'),
                    )
                ]
            )
            self.publishers.append(client.publisher(command_type, f'{topic}/cmd_vel'))
        client.until(lambda: self.process.poll() is None and self.reset(), 'the first reset')

    def call(self, service_type, name, **fields):
        return self.client.call(service_type, f'{self.namespace}/simulator/{name}', **fields)

    def clear(self):
        self.client.until(lambda: True, 'a turn')
        for messages in (self.states, *self.truth, *self.readings[0], *self.readings[1]):
            messages.clear()

    def reset(self):
        """Reset until the new episode's start has been heard on every state topic."""
        if self.command_type is TwistStamped:
            self.call(SetBool, 'pause', data=True)  # nothing is left to be sent again
        self.clear()
        response = self.call(Trigger, 'reset')
        try:
            self.client.until(lambda: self.states and all(self.truth), 'the start', 2.0)
        except AssertionError:
            return False
        return response.success

    def send(self, number, wheels=None, stamp=None, twist=None):
        twist = twist or Twist()
        if wheels is not None:
            twist.linear.x, twist.angular.z = body_speeds(wheels)
        if self.command_type is TwistStamped:
            message = TwistStamped(twist=twist)
            message.header.stamp = stamp
            self.publishers[number].publish(message)
        else:
            self.publishers[number].publish(twist)

    def reading(self, number, tick):
        scan, camera, ground, traction = (
            next(message for message in messages if _tick(message) == tick)
            for messages in self.readings[number]
        )
        return np.concatenate(
            [
                np.asarray(scan.ranges, np.float32) - RADIUS,
                camera.sectors,
                ground.darkness,
                [np.float32(traction.wrench.force.x > 0.5)],
            ]
        )

    def at(self, messages, tick):
        """The newest message that tells of this tick, when it has come.

        A start may have been told of twice: a reset whose answer is late is asked for again.
        """

        def told():
            return next((m for m in reversed(messages) if _tick(m) == tick), None)

        self.client.until(told, f'a message of tick {tick}')
        return told()

    def complete(self, ticks):
        return all(
            len({_tick(message) for message in messages}) >= ticks
            for robot in self.readings
            for messages in robot
        )


def _tick(message):
    """The tick that a message tells of; after a second without an answer it comes again."""
    headed = message.markers[0] if isinstance(message, MarkerArray) else message
    stamp = headed.header.stamp
    return round(stamp.sec * 10 + stamp.nanosec * 1e-8) - 1


def pose(message):
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    heading = 2 * math.atan2(orientation.z, orientation.w)
    return np.array([position.x, position.y, heading], np.float32)


def test_lockstep_is_the_world_bit_for_bit(lockstep, client):
    assert lockstep.reset()
    world, rng, ticks = World(), np.random.default_rng(1), 60
    lockstep.call(Step, 'step', ticks=ticks)
    for tick in range(ticks):
        client.until(lambda tick=tick: lockstep.complete(tick + 1), f'the readings of {tick}')
        expected = world.readings
        expected[:, :24][expected[:, :24] > 0.1] = np.inf
        wheels = np.rint(rng.uniform(-10, 10, (2, 2)) * 65536).astype(np.float32) / 65536
        for number in range(2):
            assert lockstep.reading(number, tick).tobytes() == expected[number].tobytes()
            scans = lockstep.readings[number][0]
            stamp = next(scan.header.stamp for scan in scans if _tick(scan) == tick)
            lockstep.send(number, wheels[number], stamp)
        assert not world.step(wheels)
        for number in range(2):
            truth = lockstep.at(lockstep.truth[number], tick + 1)
            assert pose(truth).tobytes() == world.poses[number].tobytes()
    client.until(lambda: lockstep.states[-1].tick == ticks, 'the last tick')
    assert lockstep.states[-1].paused and not lockstep.states[-1].ended


def test_a_step_that_comes_again_under_its_number_is_made_once(lockstep):
    assert lockstep.reset()
    first = lockstep.call(Step, 'step', number=5, ticks=1)
    assert first.success
    assert lockstep.call(Step, 'step', number=5, ticks=7) == first
    assert lockstep.call(Step, 'step', number=6, ticks=7) != first


def test_stamps_frames_and_scan_follow_the_conventions(lockstep, client):
    assert lockstep.reset()
    lockstep.call(Step, 'step', ticks=1)
    client.until(lambda: lockstep.complete(1), 'readings')
    scan = lockstep.readings[0][0][0]
    assert scan.header.frame_id == 'predator/base_link'
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec) == (0, 100_000_000)
    assert len(scan.ranges) == 24 and math.isinf(scan.ranges[0])
    assert scan.angle_min + 23 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert scan.range_max == np.float32(0.185) and scan.range_min < 0.085
    assert lockstep.truth[1][0].header.frame_id == 'map'
    assert lockstep.truth[1][0].child_frame_id == 'prey/base_link'
    assert pose(lockstep.truth[1][0]) == pytest.approx([0.5, 0, math.pi])
    for name in ('proximity', 'camera', 'ground', 'traction'):
        (info,) = client.node.get_publishers_info_by_topic(f'/a/prey/{name}')
        assert info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT


def test_latched_topics_reach_late_subscribers(lockstep, client):
    from marxbot_sim.interface import LATCHED

    leds = client.listen(ColorRGBA, '/a/prey/leds', LATCHED)
    description = client.listen(String, '/a/predator/robot_description', LATCHED)
    client.until(lambda: leds and description, 'the latched messages')
    assert (leds[0].r, leds[0].g, leds[0].b) == (0, 1, 0)
    for part in ('base_link', 'left_wheel_joint', 'right_wheel_joint', 'ring', 'camera'):
        assert f'"{part}"' in description[0].data


def test_markers_and_joints_follow_the_robots(lockstep, client):
    markers = client.listen(MarkerArray, '/a/arena/markers')
    joints = client.listen(JointState, '/a/prey/joint_states')
    odometry = client.listen(Odometry, '/a/prey/odom')
    client.until(
        lambda: lockstep.reset() and markers and joints and odometry,
        'markers, joints and odometry',
    )
    for messages in (markers, joints, odometry):
        messages.clear()
    lockstep.call(Step, 'step', ticks=1)
    client.until(lambda: lockstep.complete(1), 'readings')
    for number in range(2):
        lockstep.send(number, (2.0, 4.0), lockstep.readings[number][0][0].header.stamp)
    joint, moved = lockstep.at(joints, 1), lockstep.at(odometry, 1)
    assert joint.position.tolist() == pytest.approx([0.2, 0.4])
    assert moved.header.frame_id == 'prey/odom'
    # from 0, though it stood at 0.5
    assert moved.pose.pose.position.x == pytest.approx(0.027 * 3 * 0.1, rel=1e-3)
    by_name = {(m.ns, m.id): m for m in lockstep.at(markers, 1).markers}
    assert {ns for ns, _ in by_name} == {'arena', 'predator', 'prey'}
    ring = by_name['prey', 21]
    assert (ring.color.r, ring.color.g) == (0, 1)
    truth = lockstep.at(lockstep.truth[1], 1)
    assert ring.pose.position.x == truth.pose.pose.position.x
    rays, sectors = by_name['prey', 23], by_name['prey', 24]
    assert len(rays.points) == len(rays.colors) == 48
    assert len(sectors.points) == len(sectors.colors) and len(sectors.points) % 24 == 0
    seen = {index for index, color in enumerate(sectors.colors) if color.a > 0.05}
    assert 0 in seen and len(sectors.points) - 1 in seen  # the predator ahead: first and last


def test_lockstep_ignores_what_does_not_answer_the_present_readings(lockstep, client):
    assert lockstep.reset()
    lockstep.call(Step, 'step', ticks=2)
    client.until(lambda: lockstep.complete(1), 'readings')
    stamp = lockstep.readings[0][0][0].header.stamp
    late = type(stamp)(sec=77, nanosec=0)
    for number in range(2):
        lockstep.send(number, (9.0, 9.0), late)
        lockstep.send(number, (1.0, 1.0), stamp)
        lockstep.send(number, (5.0, 5.0), stamp)  # a second answer
    client.until(lambda: lockstep.states[-1].tick and lockstep.complete(2), 'the tick')
    assert lockstep.at(lockstep.truth[0], 1).twist.twist.linear.x == pytest.approx(0.027)
    assert lockstep.states[-1].tick == 1


def test_services_refuse_what_makes_no_sense_and_change_nothing(lockstep, client):
    assert lockstep.reset()
    episode = lockstep.states[-1].episode

    def placed(x, y, theta=0.0):
        return lockstep.call(
            SetPoses, 'set_poses', predator=Pose2D(x=x, y=y, theta=theta), prey=Pose2D(x=0.7)
        )

    for x, y, theta in ((1.45, 0.0, 0.0), (math.nan, 0.0, 0.0), (0.7, 0.1, 0.0), (0, 0, math.inf)):
        response = placed(float(x), y, theta)
        assert not response.success and 'expected' in response.message
    for size, friction in ((math.nan, 0.5), (0.2, 0.5), (3.0, -1.0), (3.0, math.inf)):
        response = lockstep.call(SetArena, 'set_arena', size=size, wall_friction=friction)
        assert not response.success and 'expected' in response.message
    for ticks in (0, 2_000_000):
        response = lockstep.call(Step, 'step', ticks=ticks)
        assert not response.success and 'expected 1 to' in response.message
    lockstep.call(SetBool, 'pause', data=False)
    response = lockstep.call(Step, 'step', ticks=1)
    assert not response.success and 'paused first' in response.message
    lockstep.call(SetBool, 'pause', data=True)
    assert lockstep.states[-1].episode == episode
    assert placed(-0.7, 0.3, 1.0).success
    client.until(lambda: lockstep.states[-1].episode > episode, 'the new episode')
    new = pytest.approx([-0.7, 0.3, 1.0])
    client.until(lambda: pose(lockstep.truth[0][-1]) == new, 'the new poses')


def test_the_obstacle_comes_and_goes_between_episodes(lockstep, client):
    assert lockstep.reset()
    for obstacle in (True, False):
        response = lockstep.call(
            SetArena, 'set_arena', size=2.5, obstacle=obstacle, wall_friction=0.5
        )
        assert response.success
        client.until(lambda o=obstacle: lockstep.states[-1].obstacle is o, 'the new arena')
        assert lockstep.states[-1].size == 2.5
        lockstep.clear()
        lockstep.call(Step, 'step', ticks=1)
        client.until(lambda: lockstep.complete(1), 'readings')
        world = World(Arena(size=2.5, obstacle=obstacle))
        assert lockstep.reading(0, 0)[24:].tobytes() == world.readings[0][24:].tobytes()
    lockstep.call(SetArena, 'set_arena', size=3.0, obstacle=False, wall_friction=0.5)


def _set(client, namespace, name, value):
    kind, field = (
        (ParameterType.PARAMETER_DOUBLE, 'double_value')
        if isinstance(value, float)
        else (ParameterType.PARAMETER_BOOL, 'bool_value')
    )
    parameter = Parameter(name=name, value=ParameterValue(type=kind, **{field: value}))
    service = f'{namespace}/simulator/set_parameters'
    return client.call(SetParameters, service, parameters=[parameter]).results[0]


def test_perturbations_can_be_set_live_and_are_checked(lockstep, client):
    result = _set(client, '/a', 'perturbations.camera_noise', -1.0)
    assert not result.successful and 'camera_noise' in result.reason
    assert not _set(client, '/a', 'lockstep', False).successful  # fixed at start
    assert lockstep.reset()
    assert _set(client, '/a', 'perturbations.camera_noise', 0.2).successful
    readings = []
    for _ in range(2):
        assert lockstep.reset()
        lockstep.call(Step, 'step', ticks=1)
        client.until(lambda: lockstep.complete(1), 'readings')
        readings.append(lockstep.reading(0, 0))
    assert _set(client, '/a', 'perturbations.camera_noise', 0.0).successful
    world = World().readings[0]
    assert not np.array_equal(readings[0][24:32], readings[1][24:32])  # another episode
    assert not np.array_equal(readings[0][24:32], world[24:32])
    assert (readings[0][24:32] >= 0).all() and (readings[0][24:32] <= 1).all()
    assert readings[0][32:].tobytes() == world[32:].tobytes()  # only the camera is disturbed


@pytest.fixture(scope='module')
def fast(starter, client):
    """A simulator at fifty times real time in the namespace /b that takes plain Twists."""
    options = 'real_time_factor:=50.0', 'at_end:=reset', 'episode_ticks:=400'
    process = starter(simulator('/b', *options, 'stamped_cmd_vel:=false'))
    return Arm(client, '/b', process, Twist)


def speed(arm):
    return arm.truth[0][-1].twist.twist.linear.x if arm.truth[0] else None


def test_the_watchdog_stops_a_silent_robot_and_says_so(fast, client):
    fast.reset()
    client.until(lambda: fast.send(0, (1.0, 1.0)) or speed(fast) == 0.027, 'motion')
    client.until(lambda: speed(fast) == 0.0, 'the stop')
    fast.process.wait_for_output('predator stopped: no cmd_vel for 0.6 s')


def test_nan_stops_and_absurd_speed_is_bounded(fast, client):
    fast.reset()
    client.until(lambda: fast.send(0, (1.0, 1.0)) or speed(fast) == 0.027, 'motion')
    bad = Twist()
    bad.linear.x = math.nan
    client.until(lambda: fast.send(0, twist=bad) or speed(fast) == 0.0, 'the stop')
    fast.process.wait_for_output('predator stopped by a bad cmd_vel: speeds are nan m/s')
    mad = Twist()
    mad.linear.x = 1e200
    client.until(lambda: fast.send(0, twist=mad) or speed(fast) == 0.27, 'full speed')
    fast.process.wait_for_output('predator slowed down')


numbers = st.floats(allow_nan=True, allow_infinity=True, width=64)


@given(linear=numbers, angular=numbers, other=numbers, number=st.integers(0, 1))
@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_no_twist_breaks_it(fast, linear, angular, other, number):
    twist = Twist()
    twist.linear.x, twist.angular.z = linear, angular
    twist.linear.y = twist.linear.z = twist.angular.x = other
    fast.send(number, twist=twist)


def test_it_lives_on_after_all_that(fast, client):
    client.until(fast.reset, 'a reset')
    for truth in fast.truth:
        for message in truth:
            x, y, heading = pose(message)
            assert max(abs(x), abs(y)) <= 1.5 - 0.085 + 1e-6 and math.isfinite(heading)
    assert fast.process.poll() is None


@pytest.mark.parametrize(
    ('parameter', 'sentence'),
    [
        ('physics:=magic', "physics is 'magic', expected one of kinematic, pymunk"),
        ('arena.size:=0.2', 'size is 0.2'),
        ('real_time_factor:=0.0', 'real_time_factor is 0.0, expected a number from 0.001 to 1000'),
        ('perturbations.command_loss:=1.5', 'command_loss is 1.5'),
        ('lockstep:=maybe', 'lockstep'),
    ],
)
def test_bad_parameters_are_one_sentence_and_exit_code_2(starter, parameter, sentence):
    process = starter(simulator('/d', parameter))
    assert process.wait(40) == 2
    assert sentence in process.stderr_text
    assert 'Traceback' not in process.stderr_text


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_cleanly(starter, number):
    process = starter(simulator('/c', 'real_time_factor:=20.0'))
    process.wait_for_output('arena of 3 m', 40)
    process.send_signal(number)
    assert process.wait() == 0
    assert 'Traceback' not in process.stderr_text


@given(st.tuples(*[st.integers(-30 * 65536, 30 * 65536)] * 2))
def test_wheel_speeds_survive_a_twist(wheels):
    wheels = np.array(wheels, np.float32) / np.float32(65536)
    back, limited = wheel_speeds(*body_speeds(wheels))
    assert back.tobytes() == wheels.tobytes() or (back == wheels).all()
    assert not limited


@given(*[st.floats(allow_nan=False, allow_infinity=False)] * 2)
def test_wheel_speeds_stay_within_the_limit_however_absurd_the_command(linear, angular):
    wheels, _ = wheel_speeds(linear, angular, 10.0)
    assert (np.abs(wheels) <= 10.0).all()

"""What the simulator takes, says and offers: parameters, topics and services."""

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, WrenchStamped
from marxbot_msgs.msg import ArenaState, Camera, Ground, Readings
from marxbot_msgs.srv import SetArena, SetPoses, Step
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import ColorRGBA, String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from marxbot_sensors import MARXBOT
from marxbot_sim.core.fields import options_of
from marxbot_sim.core.parameters import FASTEST, PHYSICS, ROBOTS, SLOWEST, TICK, Arena
from marxbot_sim.core.perturbations import Perturbations
from node_runner import Interface, Parameter, Service, Topic

QUEUE = QoSProfile(depth=100)
"""Reliable."""

COMMANDS = QoSProfile(depth=10)
"""Reliable."""

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable, and the last message is kept for late subscribers."""

STATES = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable, and the last messages are kept for late subscribers."""


def _group(group, kind, live):
    """Return parameters ``GROUP.FIELD`` for the described fields of a dataclass."""
    return tuple(
        Parameter(
            f'{group}.{name}',
            option.default,
            f'{option.help}, {option.unit}' if option.unit else option.help,
            low=option.minimum,
            high=option.maximum,
            choices=option.choices,
            live=live,
        )
        for name, option in options_of(kind).items()
    )


PARAMETERS = (
    Parameter(
        'physics',
        'kinematic',
        'exact motion, compiled, or rigid bodies (pymunk)',
        choices=PHYSICS,
    ),
    Parameter(
        'lockstep', False, 'make a tick when both robots have got their command, and only then'
    ),
    Parameter(
        'real_time_factor',
        1.0,
        'simulated over real time, outside lockstep',
        low=SLOWEST,
        high=FASTEST,
        live=True,
    ),
    Parameter('paused', False, 'start paused'),
    Parameter(
        'episode_ticks',
        0,
        'ticks of 0.1 s after which an episode ends; 0: only a capture ends it',
        low=0,
        high=2**31 - 1,
    ),
    Parameter(
        'at_end',
        'pause',
        "at an episode's end: wait, or start the next",
        choices=('pause', 'reset'),
    ),
    Parameter('stamped_cmd_vel', True, 'take TwistStamped on cmd_vel; false: Twist'),
    Parameter('reliable_sensors', False, 'offer the sensors reliably, 100: for recordings'),
    Parameter(
        'episode_numbers',
        RosParameter.Type.INTEGER_ARRAY,
        'numbers under which predator and prey draw what is random, from the next reset on; not '
        'set: the number of the episode',
        live=True,
    ),
    Parameter(
        'cmd_vel_timeout',
        0.5,
        's of simulated time without a command after which a robot is stopped, outside lockstep',
        low=TICK,
        high=3600.0,
    ),
    Parameter('max_wheel_speed', 10.0, 'fastest a wheel can turn, rad/s', low=0.01, high=30.0),
    *_group('arena', Arena, live=False),
    *_group('perturbations', Perturbations, live=True),
)

SENSORS = (
    Topic(
        'proximity',
        LaserScan,
        '24 infrared rays, ray i at 7.5 + 15 i degrees from the heading; m from base_link, whose '
        "body's rim lies at 0.085; +inf where nothing is within 0.1 m of the rim (REP 117)",
        qos_profile_sensor_data,
    ),
    Topic(
        'camera',
        Camera,
        "8 sectors, fraction filled by the opponent's lights, 0 to 1",
        qos_profile_sensor_data,
    ),
    Topic('ground', Ground, '4 sensors, darkness, 0 to 1', qos_profile_sensor_data),
    Topic(
        'traction',
        WrenchStamped,
        'force.x: force of walls and obstacle, N, its direction is not sensed; 1 N stands for a '
        'contact in kinematic physics',
        qos_profile_sensor_data,
    ),
    *(
        Topic(sensor.topic, Readings, sensor.text, qos_profile_sensor_data)
        for sensor in MARXBOT.further
    ),
)
"""What a controller waits for, below each robot's name."""

STATE = (
    Topic(
        'odom',
        Odometry,
        'dead reckoning from the wheels in frame odom, m, rad, with covariances; motor noise and '
        'contacts make it drift',
        QUEUE,
    ),
    Topic('ground_truth', Odometry, 'the true pose and speeds, in frame map; m, rad', QUEUE),
    Topic(
        'joint_states',
        JointState,
        'angles, rad, and speeds, rad/s, of left_wheel_joint and right_wheel_joint',
        QUEUE,
    ),
    Topic('leds', ColorRGBA, 'colour of the ring of lights', LATCHED),
    Topic('robot_description', String, 'the URDF; its frames have no prefix', LATCHED),
)
"""What a robot tells beside that."""

ARENA = (
    Topic(
        'arena/state',
        ArenaState,
        'episode, tick, captured, ended, paused, arena; after every tick',
        STATES,
    ),
    Topic(
        'arena/markers',
        MarkerArray,
        'arena, robots with lights, infrared rays, camera sectors',
        QUEUE,
    ),
    Topic('/clock', Clock, 'simulated time, every tick', QUEUE),
    Topic('/tf', TFMessage, 'map to odom to base_link to wheels, of both robots', QUEUE),
    Topic('/tf_static', TFMessage, 'the fixed frames of both robots', LATCHED),
    Topic(
        '/diagnostics',
        DiagnosticArray,
        'once a second: state, pace, ticks a second, refused commands, what is wrong around',
        COMMANDS,
    ),
)

SERVICES = (
    Service('~/reset', Trigger, "starts the next episode at the paper's start poses"),
    Service('~/pause', SetBool, 'pauses (true) or runs (false)'),
    Service(
        '~/step',
        Step,
        'lets a paused simulator make some ticks; answered at once, arena/state tells when they '
        'are made',
    ),
    Service('~/set_poses', SetPoses, 'starts the next episode at given poses, m and rad'),
    Service(
        '~/set_arena',
        SetArena,
        'starts the next episode in another arena: size, m, obstacle, friction',
    ),
)


def command_type(stamped):
    """Return the type of cmd_vel."""
    return TwistStamped if stamped else Twist


def command_topic(robot, stamped=True):
    """Return the topic of a robot's commands."""
    text = 'linear.x m/s, angular.z rad/s; Twist with stamped_cmd_vel:=false'
    return Topic(f'{robot}/cmd_vel', command_type(stamped), text, COMMANDS)


SIMULATOR = Interface(
    'marxbot_sim simulator',
    'two MarxBots, predator and prey, in an arena, in real time or in lockstep with their '
    "control. Frames: map (the arena's centre), ROBOT/odom, ROBOT/base_link (REP 103, REP 105).",
    PARAMETERS,
    subscribes=tuple(command_topic(robot) for robot in ROBOTS),
    publishes=(
        *(
            Topic(f'{robot}/{topic.name}', topic.type, topic.text, topic.qos)
            for robot in ROBOTS
            for topic in (*SENSORS, *STATE)
        ),
        *ARENA,
    ),
    services=SERVICES,
)

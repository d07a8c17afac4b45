"""What the package's nodes take, say and offer: parameters, topics and services."""

import math

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, WrenchStamped
from lifecycle_msgs.srv import ChangeState, GetState
from marxbot_msgs.msg import Camera, Ground, Neurons, Readings
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from marxbot_sensors import MARXBOT
from neuro_controller.core.drive import BODY_RADIUS, WHEEL_RADIUS, WHEEL_SEPARATION
from neuro_controller.core.genome import GENES, HIDDEN, LAYOUT, OUTPUTS
from neuro_controller.core.settings import (
    GROUND_CODINGS,
    INFRARED_RESPONSES,
    MAX_WHEEL_SPEED,
    MIN_WHEEL_SPEED,
    MOTOR_MAPS,
)
from node_runner import Interface, Parameter, Service, Topic

QUEUE = QoSProfile(depth=10)
"""Reliable."""

GENOME = Parameter(
    'genome',
    RosParameter.Type.DOUBLE_ARRAY,
    f'{GENES} genes from -5 to 5; another number of them means other than {HIDDEN} hidden neurons',
    live=True,
)

NETWORK = (
    Parameter(
        'max_wheel_speed',
        10.0,
        'wheel speed at full effort, rad/s: 8.5 or 10 in the paper',
        low=MIN_WHEEL_SPEED,
        high=MAX_WHEEL_SPEED,
        live=True,
    ),
    Parameter(
        'motor_map',
        'signed',
        "what can back up (signed), or the paper's equations, forward only (printed)",
        choices=tuple(MOTOR_MAPS),
        live=True,
    ),
    Parameter(
        'episode_ticks',
        1000,
        'ticks of 0.1 s after which the clock neuron reads 1',
        low=1,
        high=2**31 - 1,
        live=True,
    ),
    Parameter(
        'infrared_response',
        'squared',
        "infrared neurons' growth with nearness",
        choices=tuple(INFRARED_RESPONSES),
        live=True,
    ),
    Parameter(
        'ground_coding',
        'relative',
        "the ground's darkness relative to its mean, or as it is (raw)",
        choices=tuple(GROUND_CODINGS),
        live=True,
    ),
)
"""What makes another network; it starts afresh when one is set."""

LIMITS = tuple(
    Parameter(f'limits.{name}', math.inf, f'highest {what} of a command, above 0', live=True)
    for name, what in (
        ('linear_speed', 'speed, m/s,'),
        ('angular_speed', 'turning speed, rad/s,'),
        ('linear_acceleration', 'acceleration, braking too, m/s^2,'),
        ('angular_acceleration', 'turning acceleration, braking too, rad/s^2,'),
    )
)
"""Of what is sent to the robot; infinite ones leave commands untouched."""

FIXED = (
    Parameter(
        'genome_server', '', 'name of a node that holds genomes as parameters: /genome_server'
    ),
    Parameter('champion', '', 'parameter of genome_server to fetch the genome from: predator'),
    Parameter('autostart', False, 'configure and activate as soon as there is a genome'),
    Parameter(
        'trigger',
        'timer',
        'step every 0.1 s on the last readings (timer), or for each complete set of readings '
        '(sensors), as simulation needs',
        choices=('timer', 'sensors'),
    ),
    Parameter(
        'stamp_tolerance',
        0.05,
        's by which the stamps of a complete set may differ, with trigger sensors',
        low=0.0,
        high=3600.0,
    ),
    Parameter('stamped_cmd_vel', True, 'publish TwistStamped on cmd_vel; false: Twist'),
    Parameter(
        'sensor_timeout',
        0.5,
        's without a good message of a sensor, or without a complete set, after which the robot '
        'is stopped',
        low=0.1,
        high=3600.0,
    ),
    Parameter(
        'reliable_sensors',
        False,
        'subscribe to the sensors reliably: for recordings, where the robot offers it',
    ),
    Parameter(
        'contact_threshold',
        0.5,
        'traction force above which the robot counts as in contact, N',
        low=0.0,
        high=1e6,
    ),
    Parameter(
        'body_radius',
        BODY_RADIUS,
        "distance of the body's rim from the frame of proximity, m: ranges less this are what the "
        'network sees; 0 where ranges count from the rim',
        low=0.0,
        high=10.0,
    ),
    Parameter(
        'wheel_radius',
        WHEEL_RADIUS,
        'of the wheels that the network believes in, m',
        low=0.001,
        high=10.0,
    ),
    Parameter(
        'wheel_separation',
        WHEEL_SEPARATION,
        'distance between those wheels, m',
        low=0.001,
        high=10.0,
    ),
)

SENSORS = (
    Topic(
        'proximity',
        LaserScan,
        '24 ranges, m from base_link, ray i at 7.5 + 15 i degrees from the heading; what is '
        'farther from the rim than 0.1 m is not seen',
        qos_profile_sensor_data,
    ),
    Topic('camera', Camera, '8 sectors, 0 to 1', qos_profile_sensor_data),
    Topic('ground', Ground, '4 darkness values, 0 to 1', qos_profile_sensor_data),
    Topic('traction', WrenchStamped, 'horizontal force, N', qos_profile_sensor_data),
    *(
        Topic(sensor.topic, Readings, sensor.text, qos_profile_sensor_data)
        for sensor in MARXBOT.further
    ),
)

NEURONS = Topic(
    'neurons',
    Neurons,
    f'{LAYOUT.inputs} inputs, {HIDDEN} hidden, {OUTPUTS} outputs, 0 to 1, stamped as the command '
    'they led to',
    QUEUE,
)

DIAGNOSTICS = Topic(
    '/diagnostics',
    DiagnosticArray,
    'once a second: state, why the robot was stopped, commands sent, what is wrong around',
    QUEUE,
)


def command_topic(stamped=True):
    """Return the topic of the commands."""
    text = (
        'linear.x m/s, angular.z rad/s, stamped with the time of the readings it answers; Twist '
        'with stamped_cmd_vel:=false'
    )
    return Topic('cmd_vel', TwistStamped if stamped else Twist, text, QUEUE)


CONTROLLER = Interface(
    'neuro_controller controller',
    'runs one genome on one robot, in that namespace; a lifecycle node.',
    (GENOME, *NETWORK, *LIMITS, *FIXED),
    subscribes=SENSORS,
    publishes=(command_topic(), NEURONS, DIAGNOSTICS),
    services=(
        Service(
            '~/change_state',
            ChangeState,
            'configure needs a genome; activate starts afresh and drives; deactivate commands a '
            'stop',
        ),
        Service('~/get_state', GetState, 'unconfigured, inactive, active or finalized'),
        Service(
            '~/reset',
            Trigger,
            'forgets the past, as at the start of an episode; only while active',
        ),
    ),
)

GENOME_SERVER = Interface(
    'neuro_controller genome_server',
    'holds genomes as read-only parameters, arrays of double, best of their population: predator '
    'and prey of the last snapshot of the run, gen_000500.predator of each snapshot, '
    'open.predator, obstacle.prey ... as shipped. Below each stand the settings that it evolved '
    'with, such as predator.motor_map.',
    (
        Parameter(
            'run', '', 'run folder or snapshot; empty: the shipped champions of the open arena'
        ),
    ),
)

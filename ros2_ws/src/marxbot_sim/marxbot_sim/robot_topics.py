"""What one simulated robot says: its publishers, and its state as messages."""

import math
from array import array

import numpy as np
from geometry_msgs.msg import Quaternion, WrenchStamped
from marxbot_msgs.msg import Camera, Ground, Readings
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import ColorRGBA, String

from marxbot_sensors import MARXBOT
from marxbot_sim.core.drive import body_speeds
from marxbot_sim.core.layout import CAMERA, GROUND, INFRARED, TOUCH
from marxbot_sim.core.odometry import LEAST_VARIANCE
from marxbot_sim.core.parameters import BODY_RADIUS, INFRARED_RANGE, INFRARED_RAYS, TICK
from marxbot_sim.interface import QUEUE, SENSORS, STATE

WHEEL_JOINTS = ('left_wheel_joint', 'right_wheel_joint')
"""Names of the wheels' joints in the URDF."""

LED_COLORS = {'predator': (1.0, 0.0, 0.0), 'prey': (0.0, 1.0, 0.0)}
"""Colour of each robot's ring of lights, red, green, blue (paper A1)."""

_RADIUS = np.float32(BODY_RADIUS)
_LEAST_RANGE = BODY_RADIUS - 0.005  # what touches the rim is within range, whatever its rounding


def yaw_quaternion(yaw):
    """Return the rotation by `yaw`, rad, about z."""
    return Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


class RobotTopics:
    """The topics of one robot, under its name.

    Messages are made once and filled anew, which keeps a lockstep tick short.

    Parameters
    ----------
    node : rclpy.node.Node
    robot : str
        Name of the robot: its topics' namespace and the prefix of its frames.
    description : str
        The robot's URDF.
    reliable_sensors : bool
        Whether messages of the sensors are sent again where they were lost.
    """

    def __init__(self, node, robot, description, reliable_sensors=False):
        def publisher(topic, qos):
            return node.create_publisher(topic.type, f'{robot}/{topic.name}', qos)

        publishers = {
            topic.name: publisher(topic, QUEUE if reliable_sensors else topic.qos)
            for topic in SENSORS
        } | {topic.name: publisher(topic, topic.qos) for topic in STATE}
        base_frame = f'{robot}/base_link'
        self._sensors = [publishers[topic.name] for topic in SENSORS]
        self._odom = publishers['odom']
        self._ground_truth = publishers['ground_truth']
        self._joints = publishers['joint_states']

        self._scan = LaserScan(
            angle_min=math.radians(7.5),
            angle_max=math.radians(7.5 + 15 * (INFRARED_RAYS - 1)),
            angle_increment=math.radians(15),
            scan_time=TICK,
            range_min=_LEAST_RANGE,
            range_max=float(_RADIUS + np.float32(INFRARED_RANGE)),
        )
        self._camera_message, self._ground_message = Camera(), Ground()
        self._wrench = WrenchStamped()
        self._further = [Readings() for _ in MARXBOT.further]
        self._odom_message = _odometry_message(f'{robot}/odom', base_frame)
        self._truth_message = _odometry_message('map', base_frame)
        self._joint_message = JointState(name=WHEEL_JOINTS)
        for message in (
            self._scan,
            self._camera_message,
            self._ground_message,
            self._wrench,
            *self._further,
        ):
            message.header.frame_id = base_frame
        self.wheel_angles = np.zeros(2)

        red, green, blue = LED_COLORS[robot]
        publishers['leds'].publish(ColorRGBA(r=red, g=green, b=blue, a=1.0))
        publishers['robot_description'].publish(String(data=description))

    def publish_sensors(self, stamp, readings, force):
        """Publish what the controller waits for.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        readings : float32 array, shape (readings,)
            Infrared distances are published from the centre, from which they are exact in float32,
            and +inf where they are beyond the range (REP 117).
        force : float
            Force of walls and obstacle on the robot, N; its direction is not sensed.
        """
        distances = readings[INFRARED:CAMERA]
        ranges = np.where(distances > INFRARED_RANGE, np.float32(np.inf), distances + _RADIUS)
        self._scan.ranges = array('f', ranges.tobytes())
        self._camera_message.sectors = readings[CAMERA:GROUND]
        self._ground_message.darkness = readings[GROUND:TOUCH]
        self._wrench.wrench.force.x = float(force)
        for message, sensor in zip(self._further, MARXBOT.further, strict=True):
            message.values = array('f', readings[MARXBOT.rows(sensor)].tobytes())
        messages = (
            self._scan,
            self._camera_message,
            self._ground_message,
            self._wrench,
            *self._further,
        )
        for publisher, message in zip(self._sensors, messages, strict=True):
            message.header.stamp = stamp
            publisher.publish(message)

    def publish_state(self, stamp, pose, odometry, wheels, tick):
        """Publish where the robot is and believes to be.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        pose : float32 array, shape (3,)
            x and y in m and heading in rad in the map.
        odometry : marxbot_sim.core.odometry.Odometry
        wheels : float32 array, shape (2,)
            Speeds of the left and right wheel, rad/s.
        tick : int
            Ticks made in the episode; 0 puts the wheels' angles to 0.
        """
        self.wheel_angles = self.wheel_angles + wheels * TICK if tick else np.zeros(2)
        _fill(self._truth_message, stamp, map(float, pose), body_speeds(wheels))
        self._ground_truth.publish(self._truth_message)
        message = self._odom_message
        _fill(message, stamp, odometry.pose, odometry.speeds)
        message.pose.covariance = _covariance(odometry.covariance)
        message.twist.covariance = _covariance(
            np.diag([odometry.speed_variances[0], 0, odometry.speed_variances[1]])
        )
        self._odom.publish(message)
        self._joint_message.header.stamp = stamp
        self._joint_message.position = self.wheel_angles.tolist()
        self._joint_message.velocity = wheels.tolist()
        self._joints.publish(self._joint_message)


def _odometry_message(frame, child_frame):
    """Return a message of a pose that is known."""
    message = Odometry(child_frame_id=child_frame)
    message.header.frame_id = frame
    message.pose.covariance = message.twist.covariance = _covariance(np.zeros((3, 3)))
    return message


def _covariance(planar):
    """Return the 36 numbers of a covariance of x, y and yaw; what is as good as known is least."""
    whole = np.eye(6) * LEAST_VARIANCE
    whole[np.ix_((0, 1, 5), (0, 1, 5))] += planar
    return whole.ravel()


def _fill(message, stamp, pose, speeds):
    x, y, yaw = pose
    message.header.stamp = stamp
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation = yaw_quaternion(yaw)
    message.twist.twist.linear.x, message.twist.twist.angular.z = speeds

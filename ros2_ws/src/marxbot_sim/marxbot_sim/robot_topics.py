"""What one simulated robot says: its publishers, and its state as messages."""

import math
from array import array

import numpy as np
from geometry_msgs.msg import Quaternion, WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import ColorRGBA, String

from marxbot_sim.core.drive import body_speeds
from marxbot_sim.core.layout import CAMERA, GROUND, INFRARED, TOUCH
from marxbot_sim.core.parameters import INFRARED_RANGE, INFRARED_RAYS, TICK

LED_COLORS = {'predator': (1.0, 0.0, 0.0), 'prey': (0.0, 1.0, 0.0)}
"""Colour of each robot's ring of lights, red, green, blue (paper A1)."""

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable, and the last message is kept for late subscribers."""


def yaw_quaternion(yaw):
    """Return the rotation by `yaw`, rad, about z."""
    return Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


class RobotTopics:
    """The topics of one robot, under its name.

    Messages are made once and filled anew, which keeps a lockstep tick short. Whatever a
    controller does not wait for is only published while somebody listens.

    Parameters
    ----------
    node : rclpy.node.Node
    robot : str
        Name of the robot: its topics' namespace and the prefix of its frames.
    description : str
        The robot's URDF.
    """

    def __init__(self, node, robot, description):
        def sensor(message_type, topic):
            return node.create_publisher(message_type, f'{robot}/{topic}', qos_profile_sensor_data)

        def state(message_type, topic):
            return node.create_publisher(message_type, f'{robot}/{topic}', 100)

        self.base_frame = f'{robot}/base_link'
        self.odom_frame = f'{robot}/odom'
        self._proximity = sensor(LaserScan, 'proximity')
        self._camera = sensor(Camera, 'camera')
        self._ground = sensor(Ground, 'ground')
        self._traction = sensor(WrenchStamped, 'traction')
        self._odom = state(Odometry, 'odom')
        self._ground_truth = state(Odometry, 'ground_truth')
        self._joints = state(JointState, 'joint_states')
        self._leds = node.create_publisher(ColorRGBA, f'{robot}/leds', LATCHED)
        self._description = node.create_publisher(String, f'{robot}/robot_description', LATCHED)

        self._scan = LaserScan(
            angle_min=math.radians(7.5),
            angle_max=math.radians(7.5 + 15 * (INFRARED_RAYS - 1)),
            angle_increment=math.radians(15),
            scan_time=TICK,
            range_max=INFRARED_RANGE,
        )
        self._camera_message, self._ground_message = Camera(), Ground()
        self._wrench = WrenchStamped()
        self._odom_message = Odometry(child_frame_id=self.base_frame)
        self._truth_message = Odometry(child_frame_id=self.base_frame)
        self._joint_message = JointState(name=['left_wheel_joint', 'right_wheel_joint'])
        for message in (self._scan, self._camera_message, self._ground_message, self._wrench):
            message.header.frame_id = self.base_frame
        self._odom_message.header.frame_id = self.odom_frame
        self._truth_message.header.frame_id = 'map'
        self._angles = np.zeros(2)

        red, green, blue = LED_COLORS[robot]
        self._leds.publish(ColorRGBA(r=red, g=green, b=blue, a=1.0))
        self._description.publish(String(data=description))

    def publish_sensors(self, stamp, readings, force):
        """Publish what the controller waits for.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        readings : float32 array, shape (37,)
            Infrared distances beyond the range are published as +inf (REP 117).
        force : float
            Force of walls and obstacle on the robot, N; its direction is not sensed.
        """
        distances = readings[INFRARED:CAMERA]
        distances = np.where(distances > INFRARED_RANGE, np.float32(np.inf), distances)
        self._scan.ranges = array('f', distances.tobytes())
        self._camera_message.sectors = readings[CAMERA:GROUND]
        self._ground_message.darkness = readings[GROUND:TOUCH]
        self._wrench.wrench.force.x = float(force)
        for publisher, message in (
            (self._proximity, self._scan),
            (self._camera, self._camera_message),
            (self._ground, self._ground_message),
            (self._traction, self._wrench),
        ):
            message.header.stamp = stamp
            publisher.publish(message)

    def publish_state(self, stamp, pose, odometry, wheels, tick):
        """Publish where the robot is and believes to be.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        pose : float32 array, shape (3,)
            x and y in m and heading in rad in the map.
        odometry : tuple of float
            x and y in m and heading in rad by dead reckoning.
        wheels : float32 array, shape (2,)
            Speeds of the left and right wheel, rad/s.
        tick : int
            Ticks made in the episode; 0 puts the wheels' angles to 0.
        """
        linear, angular = body_speeds(wheels)
        self._angles = self._angles + wheels * TICK if tick else np.zeros(2)
        for publisher, message, (x, y, yaw) in (
            (self._odom, self._odom_message, odometry),
            (self._ground_truth, self._truth_message, map(float, pose)),
        ):
            if publisher.get_subscription_count():
                message.header.stamp = stamp
                message.pose.pose.position.x = x
                message.pose.pose.position.y = y
                message.pose.pose.orientation = yaw_quaternion(yaw)
                message.twist.twist.linear.x = linear
                message.twist.twist.angular.z = angular
                publisher.publish(message)
        if self._joints.get_subscription_count():
            self._joint_message.header.stamp = stamp
            self._joint_message.position = self._angles.tolist()
            self._joint_message.velocity = wheels.tolist()
            self._joints.publish(self._joint_message)

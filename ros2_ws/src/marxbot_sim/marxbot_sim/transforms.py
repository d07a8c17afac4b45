"""The trees of frames map -> odom -> base_link -> what a robot is made of (REP 105)."""

import math
import xml.etree.ElementTree as ElementTree

from geometry_msgs.msg import Quaternion, TransformStamped
from tf2_msgs.msg import TFMessage

from marxbot_sim.interface import LATCHED, QUEUE
from marxbot_sim.robot_topics import WHEEL_JOINTS, yaw_quaternion


def transform(parent, child, x=0.0, y=0.0, z=0.0, rotation=None):
    """Return the transform of frame `child` in frame `parent`; m, and a Quaternion."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    translation = message.transform.translation
    translation.x, translation.y, translation.z = float(x), float(y), float(z)
    message.transform.rotation = rotation or Quaternion()
    return message


def map_to_odom(pose, odometry):
    """Return x, y, yaw of the odom frame in the map, from where the robot is and believes to be.

    Parameters
    ----------
    pose : array_like, shape (3,)
        x and y in m and heading in rad in the map.
    odometry : tuple of float
        x and y in m and heading in rad in the odom frame.
    """
    x, y, heading = odometry
    yaw = float(pose[2]) - heading
    return (
        float(pose[0]) - (math.cos(yaw) * x - math.sin(yaw) * y),
        float(pose[1]) - (math.sin(yaw) * x + math.cos(yaw) * y),
        yaw,
    )


def joints(description, prefix):
    """Return the joints of a URDF as transforms at angle 0: those of wheels, and the fixed ones.

    Parameters
    ----------
    description : str
    prefix : str
        Of all frames, such as ``predator/``.

    Returns
    -------
    moving : dict
        Joint name -> TransformStamped.
    fixed : list of TransformStamped
    """
    moving, fixed = {}, []
    for joint in ElementTree.fromstring(description).iter('joint'):
        origin = joint.find('origin')
        place = [float(value) for value in origin.get('xyz').split()]
        roll = float(origin.get('rpy', '0 0 0').split()[0])
        message = transform(
            prefix + joint.find('parent').get('link'),
            prefix + joint.find('child').get('link'),
            *place,
            Quaternion(x=math.sin(roll / 2), w=math.cos(roll / 2)),
        )
        if joint.get('type') == 'fixed':
            fixed.append(message)
        else:
            moving[joint.get('name')] = message
    return moving, fixed


class Transforms:
    """Broadcasts the robots' frames on /tf and /tf_static.

    Parameters
    ----------
    node : rclpy.node.Node
    robots : dict
        Name of each robot -> its URDF.
    """

    def __init__(self, node, robots):
        self._publisher = node.create_publisher(TFMessage, '/tf', QUEUE)
        self._static_publisher = node.create_publisher(TFMessage, '/tf_static', LATCHED)
        self._message, static = TFMessage(), TFMessage()
        self._wheels = []
        for robot, description in robots.items():
            moving, fixed = joints(description, f'{robot}/')
            self._wheels.append([moving[name] for name in WHEEL_JOINTS])
            static.transforms += fixed
        self._names = list(robots)
        self._static_publisher.publish(static)

    def publish(self, stamp, poses, odometry, angles):
        """Publish where both robots and their wheels are, if somebody listens.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        poses : float32 array, shape (2, 3)
            x and y in m and heading in rad in the map.
        odometry : sequence of two tuples
            x and y in m and heading in rad by dead reckoning.
        angles : sequence of two arrays, shape (2,)
            Of left and right wheel, rad.
        """
        if not self._publisher.get_subscription_count():
            return
        transforms = []
        for robot, pose, reckoned, wheels, turned in zip(
            self._names, poses, odometry, self._wheels, angles, strict=True
        ):
            x, y, yaw = map_to_odom(pose, reckoned)
            frame = f'{robot}/odom'
            transforms.append(transform('map', frame, x, y, rotation=yaw_quaternion(yaw)))
            x, y, yaw = reckoned
            transforms.append(
                transform(frame, f'{robot}/base_link', x, y, rotation=yaw_quaternion(yaw))
            )
            for wheel, angle in zip(wheels, turned, strict=True):
                wheel.transform.rotation = wheel_rotation(angle)
                transforms.append(wheel)
        for message in transforms:
            message.header.stamp = stamp
        self._message.transforms = transforms
        self._publisher.publish(self._message)


def wheel_rotation(angle):
    """Return the rotation of a wheel whose axis, z of its own frame, lies along the robot's y.

    A turn by roll -90 degrees about x, then by `angle`, rad, about z.
    """
    half, quarter = float(angle) / 2, -math.pi / 4
    return Quaternion(
        x=math.sin(quarter) * math.cos(half),
        y=-math.sin(quarter) * math.sin(half),
        z=math.cos(quarter) * math.sin(half),
        w=math.cos(quarter) * math.cos(half),
    )

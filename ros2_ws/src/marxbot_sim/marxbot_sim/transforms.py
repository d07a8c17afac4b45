"""The tree of frames map -> odom -> base_link, where tf2_msgs is installed (REP 105)."""

import math

from geometry_msgs.msg import TransformStamped
from rclpy.qos import QoSProfile

from marxbot_sim.robot_topics import yaw_quaternion

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None


def transform(stamp, parent, child, x, y, yaw):
    """Return the planar transform of frame `child` in frame `parent`; m and rad."""
    message = TransformStamped(child_frame_id=child)
    message.header.stamp = stamp
    message.header.frame_id = parent
    message.transform.translation.x, message.transform.translation.y = float(x), float(y)
    message.transform.rotation = yaw_quaternion(yaw)
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


class Transforms:
    """Broadcasts the robots' frames on /tf; does nothing where tf2_msgs is missing."""

    def __init__(self, node):
        self._publisher = None
        if TFMessage is not None:
            self._publisher = node.create_publisher(TFMessage, '/tf', QoSProfile(depth=100))

    def publish(self, stamp, robots, poses, odometry):
        """Publish both robots' transforms."""
        if self._publisher is None or not self._publisher.get_subscription_count():
            return
        message = TFMessage()
        for robot, pose, reckoned in zip(robots, poses, odometry, strict=True):
            message.transforms.append(
                transform(stamp, 'map', robot.odom_frame, *map_to_odom(pose, reckoned))
            )
            message.transforms.append(
                transform(stamp, robot.odom_frame, robot.base_frame, *reckoned)
            )
        self._publisher.publish(message)

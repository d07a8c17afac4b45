"""The adapter node: what a robot of another make senses, as a MarxBot would say it."""

import sys

from geometry_msgs.msg import WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from node_runner import Complaints, Concerns, run_node
from robot_senses.core.lidar import RAY_ANGLES, infrared_ranges
from robot_senses.core.panorama import sectors, to_pixels
from robot_senses.interface import (
    ADAPTER,
    BUMPER,
    CAMERA,
    GROUND,
    IMAGE,
    PROXIMITY,
    SCAN,
    TRACTION,
)


class Adapter(Node):
    """See the package's README for its topics and parameters."""

    def __init__(self):
        super().__init__('adapter')
        ADAPTER.declare(self)
        self._complaints = Complaints(self.get_logger())
        self._pressed = False
        self._proximity, self._camera, self._ground, self._traction = (
            self.create_publisher(topic.type, topic.name, topic.qos)
            for topic in (PROXIMITY, CAMERA, GROUND, TRACTION)
        )
        for topic, take in (
            (SCAN, self._on_scan),
            (IMAGE, self._on_image),
            (BUMPER, self._on_bumper),
        ):
            self.create_subscription(topic.type, topic.name, take, topic.qos)
        self._concerns = Concerns(self)

    def _value(self, name):
        return self.get_parameter(name).value

    def _on_bumper(self, message):
        self._pressed = message.data

    def _on_scan(self, scan):
        found = infrared_ranges(
            scan.ranges,
            scan.angle_min,
            scan.angle_increment,
            scan.range_min,
            scan.range_max,
            self._value('scan_yaw'),
        )
        self._proximity.publish(
            LaserScan(
                header=scan.header,
                angle_min=RAY_ANGLES[0],
                angle_max=RAY_ANGLES[-1],
                angle_increment=RAY_ANGLES[1] - RAY_ANGLES[0],
                scan_time=scan.scan_time,
                range_min=scan.range_min,
                range_max=scan.range_max,
                ranges=found.tolist(),
            )
        )
        if self._value('resting_ground'):
            darkness = [self._value('darkness')] * 4
            self._ground.publish(Ground(header=scan.header, darkness=darkness))
        traction = WrenchStamped(header=scan.header)
        traction.wrench.force.x = float(self._pressed)
        self._traction.publish(traction)

    def _on_image(self, image):
        try:
            pixels = to_pixels(image.data, image.height, image.width, image.step, image.encoding)
        except ValueError as error:
            self._complaints.warn(f'image ignored: {error}')
            return
        shares = sectors(
            pixels,
            self._value('colour'),
            self._value('least_level'),
            self._value('least_excess'),
            self._value('image_yaw'),
        )
        self._camera.publish(Camera(header=image.header, sectors=shares.tolist()))


def main():
    """Run the node until it is stopped."""
    return run_node(Adapter, ADAPTER)


if __name__ == '__main__':
    sys.exit(main())

"""What the adapter takes and says: parameters and topics."""

import math

from geometry_msgs.msg import WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Bool

from node_runner import Interface, Parameter, Topic
from robot_senses.core.panorama import CHANNELS

SCAN = Topic('scan', LaserScan, 'of a lidar, m from base_link', qos_profile_sensor_data)
IMAGE = Topic(
    'image',
    Image,
    'a panorama of 360 degrees, rgb8, bgr8, rgba8 or bgra8',
    qos_profile_sensor_data,
)
BUMPER = Topic('bumper', Bool, 'whether something is touched', QoSProfile(depth=10))

PROXIMITY = Topic(
    'proximity',
    LaserScan,
    '24 ranges, m: the least of the scan within 7.5 degrees; +inf where there is none',
    qos_profile_sensor_data,
)
CAMERA = Topic(
    'camera',
    Camera,
    '8 sectors, share of their columns that show the colour, 0 to 1',
    qos_profile_sensor_data,
)
GROUND = Topic(
    'ground',
    Ground,
    '4 times the parameter darkness, with resting_ground',
    qos_profile_sensor_data,
)
TRACTION = Topic(
    'traction', WrenchStamped, 'force.x 1 N while the bumper is pressed', qos_profile_sensor_data
)

ADAPTER = Interface(
    'robot_senses adapter',
    'the four topics of a MarxBot from a lidar, a panoramic camera and a bumper. proximity, '
    'ground and traction come with each scan, camera with each image, stamped as these.',
    (
        Parameter(
            'colour',
            'green',
            "of the opponent's lights: a prey's are green, a predator's red",
            choices=tuple(CHANNELS),
        ),
        Parameter('scan_yaw', 0.0, 'of the lidar in base_link, rad', low=-10.0, high=10.0),
        Parameter(
            'image_yaw',
            math.pi,
            "where the image's left edge looks in base_link, rad; pi: its middle looks ahead",
            low=-10.0,
            high=10.0,
        ),
        Parameter(
            'least_level', 96, 'of the colour in a pixel that shows it', low=0, high=255, live=True
        ),
        Parameter(
            'least_excess',
            48,
            'of the colour over the other two in such a pixel',
            low=1,
            high=255,
            live=True,
        ),
        Parameter(
            'resting_ground',
            True,
            'publish ground, of a robot that does not sense it; false: its own driver does',
        ),
        Parameter(
            'darkness', 0.5, 'of a ground that is not sensed, 0 to 1', low=0.0, high=1.0, live=True
        ),
    ),
    subscribes=(SCAN, IMAGE, BUMPER),
    publishes=(PROXIMITY, CAMERA, GROUND, TRACTION),
)

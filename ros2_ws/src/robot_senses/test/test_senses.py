"""What a lidar and a panorama become, by answers worked out by hand, and the node itself."""

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Bool

from robot_senses.core.lidar import infrared_ranges
from robot_senses.core.panorama import sectors, to_pixels

DEGREE = np.pi / 180


def scan(**near):
    ranges = np.full(360, 2.0)
    for angle, distance in near.items():
        ranges[int(angle.strip('_'))] = distance
    return ranges


def rays(ranges, angle_min=0.0, yaw=0.0):
    # rays a little off the borders at multiples of 15 degrees
    return infrared_ranges(ranges, angle_min + 0.5 * DEGREE, DEGREE, 0.1, 3.5, yaw)


def test_each_ray_takes_the_least_range_around_it():
    found = rays(scan(_0=0.3, _14=0.2, _15=0.4, _359=0.5))
    assert found[[0, 1, 2, 23]].tolist() == [0.2, 0.4, 2.0, 0.5]


def test_a_lidar_that_starts_or_is_mounted_backwards():
    for found in (rays(scan(_180=0.3), angle_min=-np.pi), rays(scan(_180=0.3), yaw=np.pi)):
        assert found[0] == 0.3 and (found[1:] == 2.0).all()


def test_what_is_no_range_is_not_seen():
    ranges = np.full(360, np.inf)
    ranges[[3, 20, 40, 60]] = np.nan, 0.05, 0.0, 4.0
    assert np.isinf(rays(ranges)).all()
    assert np.isinf(rays(np.full(360, np.nan))).all()


def panorama(columns, colour=(20, 200, 20), width=360):
    pixels = np.full((6, width, 3), 128, np.uint8)
    pixels[3, columns] = colour
    return pixels


def test_sectors_count_columns_counter_clockwise_from_the_heading():
    # left edge at 180 degrees: column c looks at 179.5 - c degrees
    ahead_left = sectors(panorama(slice(135, 180)), 'green')
    assert ahead_left.tolist() == [1, 0, 0, 0, 0, 0, 0, 0]
    ahead_right = sectors(panorama(slice(180, 189)), 'green')
    assert np.allclose(ahead_right, [0, 0, 0, 0, 0, 0, 0, 0.2])
    behind = sectors(panorama([0, 359]), 'green')
    assert np.allclose(behind, [0, 0, 0, 1 / 45, 1 / 45, 0, 0, 0])


def test_only_the_colour_counts():
    assert sectors(panorama([100], (200, 20, 20)), 'green').sum() == 0
    assert sectors(panorama([100], (200, 20, 20)), 'red').sum() > 0
    assert sectors(panorama([100], (255, 255, 255)), 'green').sum() == 0
    assert sectors(panorama([100], (10, 90, 10)), 'green').sum() == 0


@pytest.mark.parametrize('encoding', ['rgb8', 'bgr8', 'rgba8', 'bgra8'])
def test_encodings_and_padded_rows(encoding):
    wanted = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
    channels = wanted[..., ::-1] if encoding.startswith('bgr') else wanted
    if encoding.endswith('a8'):
        channels = np.concatenate([channels, np.full((2, 3, 1), 255, np.uint8)], axis=-1)
    rows = np.concatenate([channels.reshape(2, -1), np.zeros((2, 5), np.uint8)], axis=1)
    found = to_pixels(rows.tobytes(), 2, 3, rows.shape[1], encoding)
    assert (found == wanted).all()


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        ((b'', 1, 1, 3, 'mono8'), "encoding is 'mono8'"),
        ((b'123', 1, 2, 6, 'rgb8'), 'image has 3 bytes, expected 1 rows of 6'),
        ((b'123', 1, 2, 3, 'rgb8'), 'image has 3 bytes'),
        ((b'', 0, 0, 0, 'rgb8'), 'image has 0 bytes'),
    ],
)
def test_other_images_are_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        to_pixels(*arguments)


def test_the_node_says_what_a_marxbot_says(starter, client):
    process = starter(['robot_senses', 'adapter'])
    heard = {
        name: client.listen(kind, f'/{name}', qos_profile_sensor_data)
        for name, kind in (
            ('proximity', LaserScan),
            ('camera', Camera),
            ('ground', Ground),
            ('traction', WrenchStamped),
        )
    }
    scans, images, bumpers = (
        client.publisher(kind, topic)
        for kind, topic in ((LaserScan, '/scan'), (Image, '/image'), (Bool, '/bumper'))
    )
    message = LaserScan(angle_increment=DEGREE, range_min=0.1, range_max=3.5)
    message.ranges = scan(_7=0.25).tolist()
    image = Image(height=6, width=360, step=1080, encoding='rgb8')
    image.data = panorama(slice(135, 180)).tobytes()
    message.header.stamp.sec = image.header.stamp.sec = 7

    def complete():
        bumpers.publish(Bool(data=True))
        scans.publish(message)
        images.publish(image)
        return all(heard.values()) and heard['traction'][-1].wrench.force.x == 1.0

    client.until(complete, 'all four topics')
    assert heard['proximity'][-1].ranges[0] == 0.25
    assert heard['camera'][-1].sectors.tolist() == [1, 0, 0, 0, 0, 0, 0, 0]
    assert heard['ground'][-1].darkness.tolist() == [0.5] * 4
    assert {messages[-1].header.stamp.sec for messages in heard.values()} == {7}
    images.publish(Image(encoding='mono8'))
    client.until(lambda: 'image ignored: encoding is' in process.stderr_text, 'the complaint')

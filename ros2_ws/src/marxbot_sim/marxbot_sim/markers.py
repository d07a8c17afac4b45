"""The arena and the robots as RViz and Foxglove markers."""

import math

from geometry_msgs.msg import Point
from rclpy.duration import Duration
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from marxbot_sim.core.layout import CAMERA, GROUND, INFRARED
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    CAMERA_SECTORS,
    INFRARED_RANGE,
    INFRARED_RAYS,
    OBSTACLE_RADIUS,
)
from marxbot_sim.robot_topics import LED_COLORS, yaw_quaternion

BODY_HEIGHT = 0.12
"""Height at which the bodies are drawn, m."""

_SECTOR_RADIUS = 0.3
_ARC_STEPS = 2


def _point(radius, angle, height=0.0):
    return Point(x=radius * math.cos(angle), y=radius * math.sin(angle), z=height)


def _marker(namespace, number, kind, color, scale=(1.0, 1.0, 1.0), height=0.0):
    marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.header.frame_id = 'map'
    marker.pose.orientation.w = 1.0
    marker.pose.position.z = height
    marker.scale.x, marker.scale.y, marker.scale.z = scale
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = color
    marker.lifetime = Duration(seconds=0).to_msg()
    return marker


class _RobotMarkers:
    """Body, ring of lights, heading, infrared rays and camera sectors of one robot."""

    def __init__(self, robot, number):
        light = LED_COLORS[robot]
        first = 10 * number
        diameter = 2 * BODY_RADIUS
        body = _marker(
            robot,
            first,
            Marker.CYLINDER,
            (0.25, 0.25, 0.28, 1.0),
            (diameter, diameter, BODY_HEIGHT),
            BODY_HEIGHT / 2,
        )
        ring = _marker(
            robot, first + 1, Marker.LINE_STRIP, (*light, 1.0), (0.02, 0.0, 0.0), BODY_HEIGHT
        )
        ring.points = [_point(BODY_RADIUS, math.radians(15 * i)) for i in range(25)]
        heading = _marker(
            robot,
            first + 2,
            Marker.ARROW,
            (1.0, 1.0, 1.0, 1.0),
            (BODY_RADIUS, 0.02, 0.02),
            BODY_HEIGHT + 0.01,
        )
        self._rays = _marker(
            robot, first + 3, Marker.LINE_LIST, (1.0, 1.0, 0.0, 1.0), (0.006, 0.0, 0.0), 0.03
        )
        for i in range(INFRARED_RAYS):
            angle = math.radians(7.5 + 15 * i)
            self._rays.points += [
                _point(BODY_RADIUS, angle),
                _point(BODY_RADIUS + INFRARED_RANGE, angle),
            ]
        self._sectors = _marker(
            robot, first + 4, Marker.TRIANGLE_LIST, (1.0, 1.0, 1.0, 1.0), height=0.02
        )
        step = 2 * math.pi / (CAMERA_SECTORS * _ARC_STEPS)
        for i in range(CAMERA_SECTORS * _ARC_STEPS):
            self._sectors.points += [
                Point(),
                _point(_SECTOR_RADIUS, i * step),
                _point(_SECTOR_RADIUS, (i + 1) * step),
            ]
        seen = next(color for name, color in LED_COLORS.items() if name != robot)
        self._seen = seen
        self.markers = [body, ring, heading, self._rays, self._sectors]

    def update(self, stamp, pose, readings):
        x, y, heading = map(float, pose)
        orientation = yaw_quaternion(heading)
        for marker in self.markers:
            marker.header.stamp = stamp
            marker.pose.position.x, marker.pose.position.y = x, y
            marker.pose.orientation = orientation
        colors = []
        for distance in readings[INFRARED:CAMERA]:
            activation = max(0.0, 1.0 - float(distance) / INFRARED_RANGE)
            color = ColorRGBA(r=1.0, g=1.0 - activation, b=0.0, a=0.15 + 0.85 * activation)
            colors += [color, color]
        self._rays.colors = colors
        red, green, blue = self._seen
        colors = []
        for fraction in readings[CAMERA:GROUND]:
            color = ColorRGBA(r=red, g=green, b=blue, a=0.03 + 0.6 * float(fraction))
            colors += [color] * (3 * _ARC_STEPS)
        self._sectors.colors = colors


class ArenaMarkers:
    """One MarkerArray that draws everything, its static parts made once."""

    def __init__(self):
        self._robots = [
            _RobotMarkers(robot, number) for number, robot in enumerate(LED_COLORS, start=1)
        ]

    def message(self, stamp, arena, poses, readings):
        """Return the markers of the present state.

        Parameters
        ----------
        stamp : builtin_interfaces.msg.Time
        arena : marxbot_sim.core.parameters.Arena
        poses : float32 array, shape (2, 3)
            x and y in m, heading in rad.
        readings : float32 array, shape (2, 37)
        """
        half = arena.size / 2
        floor = _marker(
            'arena',
            0,
            Marker.CUBE,
            (0.75, 0.75, 0.75, 1.0),
            (arena.size, arena.size, 0.01),
            -0.006,
        )
        walls = _marker(
            'arena', 1, Marker.LINE_STRIP, (0.05, 0.05, 0.05, 1.0), (0.02, 0.0, 0.0), 0.05
        )
        walls.points = [
            Point(x=x * half, y=y * half)
            for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
        ]
        obstacle = _marker(
            'arena',
            2,
            Marker.CYLINDER,
            (0.1, 0.1, 0.1, 1.0),
            (2 * OBSTACLE_RADIUS, 2 * OBSTACLE_RADIUS, 0.2),
            0.1,
        )
        obstacle.action = Marker.ADD if arena.obstacle else Marker.DELETE
        static = [floor, walls, obstacle]
        for marker in static:
            marker.header.stamp = stamp
        for robot, pose, reading in zip(self._robots, poses, readings, strict=True):
            robot.update(stamp, pose, reading)
        return MarkerArray(markers=static + [m for robot in self._robots for m in robot.markers])

"""The sensors of a MarxBot, each described once; sizes, offsets and texts follow from here."""

from marxbot_sensors.robot import CAMERA, GROUND, INFRARED, MARXBOT, TOUCH, Robot
from marxbot_sensors.sensor import Sensor

__all__ = ['CAMERA', 'GROUND', 'INFRARED', 'MARXBOT', 'TOUCH', 'Robot', 'Sensor']

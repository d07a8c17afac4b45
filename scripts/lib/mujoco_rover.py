"""A robot of another make in MuJoCo: two driven wheels, casters, lidar, panorama and bumper."""

import math

import mujoco
import numpy as np

RADIUS, WHEEL_RADIUS, SEPARATION = 0.09, 0.033, 0.16
"""Of body and wheels, and between the wheels, m."""

MAX_WHEEL_SPEED = 8.0
"""rad/s: 0.26 m/s."""

PREY_RADIUS = 0.085
SENSOR_OFFSET = 0.05
"""Of the ground sensors from the middle, forward and aside, m."""

HALF_DIAGONAL = 1.5 * math.sqrt(2)
TICK, STEP = 0.1, 0.002
CHECK = 5
"""Steps from one look at contacts to the next."""

RAYS, COLUMNS = 360, 720
LIDAR_RANGE = (0.05, 3.5)
_LIDAR_HEIGHT, _CAMERA_HEIGHT = 0.085, 0.11

_MODEL = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1"/>
    <geom name="east" type="box" size="0.05 1.6 0.1" pos="1.55 0 0.1" rgba="0.05 0.05 0.05 1"/>
    <geom name="west" type="box" size="0.05 1.6 0.1" pos="-1.55 0 0.1" rgba="0.05 0.05 0.05 1"/>
    <geom name="north" type="box" size="1.6 0.05 0.1" pos="0 1.55 0.1" rgba="0.05 0.05 0.05 1"/>
    <geom name="south" type="box" size="1.6 0.05 0.1" pos="0 -1.55 0.1" rgba="0.05 0.05 0.05 1"/>
    <body name="rover">
      <freejoint/>
      <geom name="chassis" type="cylinder" size="0.09 0.035" pos="0 0 0.055" mass="1"
            friction="0.5 0.005 0.0001" rgba="0.6 0.6 0.6 1"/>
      <geom name="lights" type="cylinder" size="0.08 0.015" pos="0 0 0.105" mass="0.05"
            rgba="0.9 0.1 0.1 1"/>
      <geom name="front" type="sphere" size="0.015" pos="0.065 0 0.016" mass="0.02" condim="1"
            priority="1"/>
      <geom name="rear" type="sphere" size="0.015" pos="-0.065 0 0.016" mass="0.02" condim="1"
            priority="1"/>
      <body name="left" pos="0 0.08 0.033">
        <joint name="left" axis="0 1 0" damping="0.0005"/>
        <geom type="cylinder" size="0.033 0.003" euler="90 0 0" mass="0.05"
              friction="1 0.005 0.0001"/>
      </body>
      <body name="right" pos="0 -0.08 0.033">
        <joint name="right" axis="0 1 0" damping="0.0005"/>
        <geom type="cylinder" size="0.033 0.003" euler="90 0 0" mass="0.05"
              friction="1 0.005 0.0001"/>
      </body>
    </body>
    <body name="prey" mocap="true">
      <geom name="prey" type="cylinder" size="0.085 0.045" pos="0 0 0.05" rgba="0.6 0.6 0.6 1"/>
      <geom name="prey_lights" type="cylinder" size="0.085 0.015" pos="0 0 0.11"
            rgba="0.1 0.9 0.1 1"/>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="left" kv="0.3" forcerange="-0.5 0.5"/>
    <velocity joint="right" kv="0.3" forcerange="-0.5 0.5"/>
  </actuator>
</mujoco>
"""


class Rover:
    """The robot in its arena, with a prey that somebody else moves."""

    def __init__(self):
        self._model = mujoco.MjModel.from_xml_string(_MODEL)
        self._data = mujoco.MjData(self._model)
        self._body = self._model.body('rover').id
        self._chassis = self._model.geom('chassis').id
        walls = ('east', 'west', 'north', 'south')
        self._walls = [self._model.geom(name).id for name in walls]

    def reset(self, pose, prey):
        """Place both; poses are x, y, heading in m and rad."""
        mujoco.mj_resetData(self._model, self._data)
        x, y, heading = pose
        self._data.qpos[:7] = x, y, 0, math.cos(heading / 2), 0, 0, math.sin(heading / 2)
        self._prey = np.array(prey[:2])
        self._data.mocap_pos[0] = *self._prey, 0
        mujoco.mj_forward(self._model, self._data)
        self.pressed = False

    @property
    def pose(self):
        """X and y in m, heading in rad."""
        x, y, _, w, _, _, z = self._data.qpos[:7]
        return x, y, 2 * math.atan2(z, w)

    def step(self, linear, angular, prey):
        """Drive for a tick while the prey moves to a place; return whether they touched."""
        turn = angular * SEPARATION / 2
        wheels = np.array([linear - turn, linear + turn]) / WHEEL_RADIUS
        self._data.ctrl[:] = np.clip(wheels, -MAX_WHEEL_SPEED, MAX_WHEEL_SPEED)
        start, self._prey = self._prey, np.array(prey[:2])
        touched = self.pressed = False
        steps = round(TICK / STEP)
        for k in range(1, steps + 1):
            self._data.mocap_pos[0, :2] = start + (self._prey - start) * k / steps
            mujoco.mj_step(self._model, self._data)
            if k % CHECK == 0:
                away = self._data.qpos[:2] - self._data.mocap_pos[0, :2]
                touched |= math.hypot(*away) <= RADIUS + PREY_RADIUS
                pairs = self._data.contact.geom
                ours = pairs[(pairs == self._chassis).any(axis=1)]
                self.pressed |= bool(np.isin(ours, self._walls).any())
        mujoco.mj_forward(self._model, self._data)
        return touched

    def ground(self):
        """Return the darkness under four sensors: front left and right, rear left and right.

        The floor is printed as the MarxBot's arena: darker from the centre to the corners.
        """
        x, y, heading = self.pose
        cosine, sine = math.cos(heading), math.sin(heading)
        places = [(a * SENSOR_OFFSET, b * SENSOR_OFFSET) for a in (1, -1) for b in (1, -1)]
        return [
            math.hypot(x + a * cosine - b * sine, y + a * sine + b * cosine) / HALF_DIAGONAL
            for a, b in places
        ]

    def scan(self):
        """Return the lidar's 360 ranges, m, counter-clockwise from the heading."""
        return self._cast(2 * np.pi * np.arange(RAYS) / RAYS, _LIDAR_HEIGHT)[0]

    def panorama(self):
        """Return a picture of 360 degrees by casting rays, uint8 (1, 720, 3), its middle ahead."""
        angles = np.pi - 2 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
        geoms = self._cast(angles, _CAMERA_HEIGHT)[1]
        pixels = np.where(geoms[:, None] < 0, 0.5, self._model.geom_rgba[geoms, :3])
        return np.round(255 * pixels).astype(np.uint8)[None]

    def _cast(self, angles, height):
        x, y, heading = self.pose
        directions = np.column_stack(
            [np.cos(angles + heading), np.sin(angles + heading), np.zeros(len(angles))]
        )
        geoms = np.full(len(angles), -1, np.int32)
        distances = np.zeros(len(angles))
        mujoco.mj_multiRay(
            m=self._model,
            d=self._data,
            pnt=np.array([x, y, height]),
            vec=directions.ravel(),
            geomgroup=None,
            flg_static=1,
            bodyexclude=self._body,
            geomid=geoms,
            dist=distances,
            normal=None,
            nray=len(angles),
            cutoff=10.0,
        )
        return np.where(geoms < 0, np.inf, distances), geoms

"""Robots that run now, from their ROS topics, and what their services can be asked."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose2D
from marxbot_msgs.msg import ArenaState, Camera, Neurons
from marxbot_msgs.srv import SetPoses, Step
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.task import Future
from sensor_msgs.msg import JointState, LaserScan
from std_srvs.srv import SetBool, Trigger

from coevo_manager.analysis.report.packing import constants, layer_places
from coevo_manager.core.environment import Environment
from coevo_manager.core.species import SPECIES
from marxbot_sim.core.parameters import BODY_RADIUS, INFRARED_RANGE, OBSTACLE_RADIUS
from neuro_controller.core.genome import MAX_HIDDEN, Layout
from node_runner import ask, make_executor, new_number

TIMEOUT = 5.0
"""How long a service may take to answer, s."""

MOST_STEPS = 1000
"""Ticks that one command makes at most."""

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RosRobots:
    """Listens to two robots and their arena in a thread of its own.

    Its node is told nothing that the robots' own topics do not say, and it orders nothing but what
    the services of simulator and controllers offer.

    Attributes
    ----------
    failure : str
        What ended the thread, '' while it turns.
    """

    def __init__(self) -> None:
        self.failure = ''
        self._node = Node('dashboard', start_parameter_services=False)
        self._robots: dict[str, dict[str, Any]] = {
            species: {'x': None, 'y': None, 'heading': 0.0, 'wheels': [0.0, 0.0]}
            for species in SPECIES
        }
        self._activations: dict[str, dict[str, Any]] = {species: {} for species in SPECIES}
        self._arena: dict[str, Any] = {}
        self._diagnostics: dict[str, dict[str, Any]] = {}
        self._heard = 0
        self._frame: tuple[int, dict[str, Any]] = (-1, {})
        self._orders: queue.SimpleQueue[tuple[Callable[[], str], queue.SimpleQueue[str]]] = (
            queue.SimpleQueue()
        )
        self._ended = threading.Event()
        self._listen()
        services = {
            'reset': (Trigger, '/simulator/reset'),
            'pause': (SetBool, '/simulator/pause'),
            'step': (Step, '/simulator/step'),
            'poses': (SetPoses, '/simulator/set_poses'),
        }
        self._clients = {
            name: self._node.create_client(*service) for name, service in services.items()
        }
        self._clients |= {
            species: self._node.create_client(
                SetParametersAtomically, f'/{species}/controller/set_parameters_atomically'
            )
            for species in SPECIES
        }
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        sensors, reliable = qos_profile_sensor_data, QoSProfile(depth=10)
        for species in SPECIES:
            for kind, name, take, qos in (
                (LaserScan, 'proximity', self._on_proximity, sensors),
                (Camera, 'camera', self._on_camera, sensors),
                (Neurons, 'neurons', self._on_neurons, reliable),
                (JointState, 'joint_states', self._on_joints, reliable),
                (Odometry, 'ground_truth', self._on_pose, reliable),
            ):
                self._node.create_subscription(
                    kind, f'/{species}/{name}', partial(take, species), qos
                )
        self._node.create_subscription(ArenaState, '/arena/state', self._on_arena, _LATCHED)
        self._node.create_subscription(
            DiagnosticArray, '/diagnostics', self._on_diagnostics, reliable
        )

    def close(self) -> None:
        """End the thread and leave ROS."""
        self._ended.set()
        self._thread.join()
        self._node.destroy_node()

    def frame(self) -> dict[str, Any]:
        """Return what was heard last, ready for JSON; the same one until something is new."""
        heard = self._heard
        if self._frame[0] != heard:
            self._frame = heard, self._make_frame()
        return self._frame[1]

    def _make_frame(self) -> dict[str, Any]:
        arena, activations = self._arena, list(self._activations.values())
        hidden = max((len(each.get('hidden', ())) for each in activations), default=0)
        environment = Environment(hidden=hidden) if 0 < hidden <= MAX_HIDDEN else Environment()
        world = constants(environment) | {'speeds': [None, None]}
        if arena:
            world['arena'] = arena['size']
            world['obstacle'] = OBSTACLE_RADIUS if arena['obstacle'] else 0
        return {
            'world': world,
            'arena': arena or None,
            'failure': self.failure,
            'diagnostics': list(self._diagnostics.values()),
            'robots': [
                self._robots[species] | {'neurons': _channels(each, environment.layout)}
                for species, each in zip(SPECIES, activations, strict=True)
            ],
        }

    def order(self, command: str, values: dict[str, Any]) -> str:
        """Ask a service; returns '' or, in a sentence, why it was not done.

        Parameters
        ----------
        command : str
            'reset'; 'pause' with `paused`; 'step' with `ticks`; 'poses' with `robots`, two of
            [x, y, heading] in m and rad; 'genome' with `species` and `parameters`.
        """
        try:
            send = self._request(command, values)
        except (KeyError, TypeError, ValueError):
            return f'the command {command[:20]!r} is not known with such values'
        answer: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._orders.put((send, answer))
        try:
            return answer.get(timeout=2 * TIMEOUT)
        except queue.Empty:
            return 'the robots do not answer'

    def _request(self, command: str, values: dict[str, Any]) -> Callable[[], str]:
        name, request = command, None
        if command == 'reset':
            request = Trigger.Request()
        elif command == 'pause':
            request = SetBool.Request(data=bool(values['paused']))
        elif command == 'step':
            ticks = min(max(int(values['ticks']), 1), MOST_STEPS)
            request = Step.Request(number=new_number(), ticks=ticks)
        elif command == 'poses':
            predator, prey = (
                Pose2D(**dict(zip(('x', 'y', 'theta'), map(float, pose), strict=True)))
                for pose in values['robots']
            )
            request = SetPoses.Request(predator=predator, prey=prey)
        elif command == 'genome':
            name = values['species']
            parameters = [Parameter(key, value=v) for key, v in values['parameters'].items()]
            request = SetParametersAtomically.Request(
                parameters=[parameter.to_parameter_msg() for parameter in parameters]
            )
        client = self._clients[name]
        if request is None:
            raise ValueError

        def send() -> str:
            if not client.service_is_ready():
                return f'{client.srv_name} is not there'

            def call() -> Future:
                return client.call_async(request)

            try:
                response = ask(self._executor, call, TIMEOUT, f'an answer of {client.srv_name}')
            except TimeoutError as error:
                return str(error)
            response = getattr(response, 'result', response)
            done = getattr(response, 'success', getattr(response, 'successful', True))
            text = getattr(response, 'message', getattr(response, 'reason', ''))
            return '' if done else text or 'it was refused'

        return send

    def _spin(self) -> None:
        self._executor = make_executor(self._node)
        try:
            while not self._ended.is_set():
                self._executor.spin_once(timeout_sec=0.05)
                while not self._orders.empty():
                    send, answer = self._orders.get()
                    answer.put(send())
        except Exception as error:
            self.failure = f'the topics are heard no more: {error}'
            self._heard += 1
        finally:
            self._executor.shutdown()

    def _on_proximity(self, species: str, scan: LaserScan) -> None:
        distances = np.asarray(scan.ranges) - BODY_RADIUS
        self._keep(species, infrared=np.clip(1 - distances / INFRARED_RANGE, 0, 1))

    def _on_camera(self, species: str, camera: Camera) -> None:
        self._keep(species, camera=camera.sectors)

    def _on_neurons(self, species: str, message: Neurons) -> None:
        self._keep(species, inputs=message.inputs, hidden=message.hidden, motors=message.outputs)

    def _keep(self, species: str, **activations: Any) -> None:
        self._activations[species] = self._activations[species] | activations
        self._heard += 1

    def _on_joints(self, species: str, message: JointState) -> None:
        if len(message.velocity) == 2:
            self._robots[species] = self._robots[species] | {'wheels': list(message.velocity)}
            self._heard += 1

    def _on_pose(self, species: str, message: Odometry) -> None:
        pose = message.pose.pose
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        place = {'x': pose.position.x, 'y': pose.position.y, 'heading': heading}
        self._robots[species] = self._robots[species] | place
        self._heard += 1

    def _on_arena(self, state: ArenaState) -> None:
        names = ('episode', 'tick', 'captured', 'ended', 'paused', 'size', 'obstacle')
        self._arena = {name: getattr(state, name) for name in names}
        self._heard += 1

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        told = dict(self._diagnostics)
        for status in message.status:
            told[status.name] = {
                'name': status.name,
                'level': ord(status.level) if isinstance(status.level, bytes) else status.level,
                'message': status.message,
                'values': [[pair.key, pair.value] for pair in status.values],
            }
        self._diagnostics = told
        self._heard += 1


def _channels(activations: dict[str, Any], layout: Layout) -> list[float]:
    """Return the activations of a robot as `layer_places` places them; 0 where none was heard."""
    places = layer_places(layout)
    inputs = places['rays']
    hidden = inputs + layout.inputs
    motors = hidden + layout.hidden
    channels = np.zeros(places['channels'])
    for name, start, end in (
        ('infrared', 0, inputs),
        ('inputs', inputs, hidden),
        ('hidden', hidden, motors),
        ('motors', motors, len(channels)),
        ('camera', places['camera'], places['camera'] + places['sectors']),
    ):
        values = np.asarray(activations.get(name, ()), float)[: end - start]
        channels[start : start + len(values)] = values
    return channels.round(3).tolist()

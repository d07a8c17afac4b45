"""The controller node: a lifecycle node that runs one genome on one robot."""

import sys
from array import array
from dataclasses import fields

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, TwistStamped, WrenchStamped
from marxbot_msgs.msg import Camera, Ground
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType, JumpThreshold
from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float32MultiArray
from std_srvs.srv import Trigger

from neuro_controller.core.controller import Controller
from neuro_controller.core.drive import WHEEL_RADIUS, WHEEL_SEPARATION
from neuro_controller.core.genome import GENES
from neuro_controller.core.limits import Limits
from neuro_controller.core.pilot import PERIOD, Pilot
from neuro_controller.genome_client import GenomeClient
from neuro_controller.sensors import READINGS, Sensors
from node_runner import Complaints, run_node

TRIGGERS = ('timer', 'sensors')

_NETWORK = {
    'max_wheel_speed': (10.0, 'wheel speed at full effort, rad/s: 8.5 or 10 in the paper'),
    'motor_map': ('signed', "'signed' (can back up) or 'printed' (forward only)"),
    'episode_ticks': (1000, 'ticks of 0.1 s after which the clock neuron reads 1'),
    'infrared_response': ('squared', "infrared activation, 'squared' or 'linear' in nearness"),
    'ground_coding': ('relative', "ground neurons 'relative' to their mean, or 'raw'"),
}
_FIXED = {
    'genome_server': (
        '',
        'name of a node that holds genomes as parameters, such as /genome_server',
    ),
    'champion': ('', 'parameter of genome_server to fetch the genome from, such as predator'),
    'autostart': (False, 'configure and activate as soon as there is a genome'),
    'trigger': (
        'timer',
        "when to step: 'timer', every 0.1 s; 'sensors', for each set of readings with one stamp",
    ),
    'stamped_cmd_vel': (False, 'publish TwistStamped on cmd_vel instead of Twist'),
    'sensor_timeout': (
        0.5,
        's without a good message of a sensor after which the robot is stopped',
    ),
    'contact_threshold': (0.5, 'traction force above which the robot counts as in contact, N'),
    'wheel_radius': (WHEEL_RADIUS, 'radius of the wheels that the network believes in, m'),
    'wheel_separation': (WHEEL_SEPARATION, 'distance between those wheels, m'),
}
_SENSOR_TYPES = {
    'proximity': LaserScan,
    'camera': Camera,
    'ground': Ground,
    'traction': WrenchStamped,
}


class ControllerNode(LifecycleNode):
    """Wraps `Pilot`; see the package's README for its topics, parameters and services."""

    def __init__(self):
        super().__init__('controller')
        self._declare_parameters()
        self._on_sensors = self._value('trigger') == 'sensors'
        self._timeout = self._value('sensor_timeout')
        if self._value('trigger') not in TRIGGERS:
            raise ValueError(
                f'trigger is {self._value("trigger")!r}, expected one of {", ".join(TRIGGERS)}'
            )
        for name in ('sensor_timeout', 'wheel_radius', 'wheel_separation'):
            if not self._value(name) > 0:
                raise ValueError(f'{name} is {self._value(name)}, expected a number above 0')
        # Compiled now, not at the first tick.
        Controller(np.zeros(GENES), 1.0).step(np.zeros(READINGS))
        self._pilot = self._make_pilot({})
        self._sensors = Sensors(self._value('contact_threshold'))
        self._message = TwistStamped() if self._value('stamped_cmd_vel') else Twist()
        self._complaints = Complaints(self.get_logger())
        self._active = False
        self._steps = 0
        self._answered_stamp = None
        self._trouble = ''
        self._refused = ''

        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_service(Trigger, '~/reset', self._on_reset)
        self._refuse_wrong_transitions()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._step_clock = steady if self._on_sensors else self.get_clock()
        self.create_timer(1.0, self._report, clock=steady)
        self._jump_handle = self.get_clock().create_jump_callback(
            JumpThreshold(
                min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=False
            ),
            post_callback=self._on_time_jump,
        )
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        self._find_genome()

    def _find_genome(self):
        """Ask the genome server, or start with the genome that is set, as the parameters say."""
        server, autostart = self._value('genome_server'), self._value('autostart')
        if server:
            if self._pilot is not None:
                raise ValueError('genome and genome_server are both set, expected one of them')
            self._genome_client = GenomeClient(
                self, server, self._value('champion'), self._on_genome
            )
        elif autostart:
            if self._pilot is None:
                raise ValueError('genome is not set, expected it or genome_server with autostart')
            self._start()

    # Parameters

    def _declare_parameters(self):
        self.declare_parameter(
            'genome',
            Parameter.Type.DOUBLE_ARRAY,
            ParameterDescriptor(description=f'{GENES} genes in [-5, 5]'),
        )
        for name, (default, text) in {**_NETWORK, **_FIXED}.items():
            self.declare_parameter(
                name, default, ParameterDescriptor(description=text, read_only=name in _FIXED)
            )
        for field in fields(Limits):
            self.declare_parameter(
                f'limits.{field.name}',
                field.default,
                ParameterDescriptor(description='see Limits'),
            )

    def _value(self, name):
        return self.get_parameter_or(name, Parameter(name)).value

    def _make_pilot(self, changes):
        """Return a pilot of the present parameters with some changed; None without a genome."""

        def value(name):
            return changes.get(name, self._value(name))

        limits = Limits(**{field.name: value(f'limits.{field.name}') for field in fields(Limits)})
        genome = value('genome')
        missing = genome is None and 'genome' not in changes
        controller = Controller(
            np.zeros(GENES) if missing else np.asarray(genome),
            **{name: value(name) for name in _NETWORK},
        )
        wheels = self._value('wheel_radius'), self._value('wheel_separation')
        return None if missing else Pilot(controller, limits, *wheels)

    def _check_parameters(self, parameters):
        try:
            self._make_pilot({parameter.name: parameter.value for parameter in parameters})
        except ValueError as error:
            self.get_logger().warning(f'parameters refused: {error}')
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_parameters(self, parameters):
        """Swap the pilot. Another network starts afresh; other limits keep the network."""
        names = {parameter.name for parameter in parameters}
        pilot = self._make_pilot({})
        if names & {'genome', *_NETWORK}:
            self._pilot = pilot
            self.get_logger().info(f'new network: {", ".join(sorted(names))} set')
        elif self._pilot is not None:
            self._pilot.limits = pilot.limits

    def _on_genome(self, genome):
        result = self.set_parameters([Parameter('genome', Parameter.Type.DOUBLE_ARRAY, genome)])[0]
        if result.successful and self._value('autostart'):
            self._start()

    # Lifecycle

    def _refuse_wrong_transitions(self):
        """Answer a transition that the state forbids; rclpy would let the process die of it."""
        change_state = self._service_change_state.callback

        def refuse(request, response):
            try:
                return change_state(request, response)
            except rclpy_implementation.RCLError:
                self._complaints.warn(
                    f'transition refused: {request.transition.label or request.transition.id} '
                    'is not possible in this state'
                )
                response.success = False
                return response

        self._service_change_state.callback = refuse

    def _start(self):
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def on_configure(self, state):
        """Open the robot's topics; fails without a genome."""
        if self._pilot is None:
            self.get_logger().error('cannot be configured: genome is not set')
            return TransitionCallbackReturn.FAILURE
        self._command_publisher = self.create_lifecycle_publisher(
            type(self._message), 'cmd_vel', 10
        )
        self._neurons_publisher = self.create_lifecycle_publisher(Float32MultiArray, 'neurons', 10)
        self._sensor_subscriptions = [
            self.create_subscription(
                message_type,
                sensor,
                lambda message, sensor=sensor: self._on_sensor(sensor, message),
                qos_profile_sensor_data,
            )
            for sensor, message_type in _SENSOR_TYPES.items()
        ]
        self._timer = self.create_timer(PERIOD, self._on_timer, clock=self._step_clock)
        return super().on_configure(state)

    def on_activate(self, state):
        """Start to drive, with a network that remembers nothing."""
        self._begin()
        self._active = True
        self.get_logger().info('active')
        return super().on_activate(state)

    def on_deactivate(self, state):
        """Stop the robot, then be silent."""
        self._halt()
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        """Close the robot's topics."""
        self._close()
        return super().on_cleanup(state)

    def on_shutdown(self, state):
        """Stop the robot and close its topics."""
        self._halt()
        if state.label != 'unconfigured':
            self._close()
        return super().on_shutdown(state)

    def destroy_node(self):
        """Stop the robot before the process ends."""
        self._halt()
        super().destroy_node()

    def _halt(self):
        if self._active:
            self._active = False
            self._pilot.stop()
            self._publish_command(self._stamp())

    def _close(self):
        for subscription in self._sensor_subscriptions:
            self.destroy_subscription(subscription)
        self.destroy_timer(self._timer)
        self.destroy_lifecycle_publisher(self._command_publisher)
        self.destroy_lifecycle_publisher(self._neurons_publisher)

    # Steps

    def _now(self):
        return self._step_clock.now().nanoseconds * 1e-9

    def _stamp(self):
        """Return the time for a message: where sensors trigger, that of the last answered set."""
        return self._answered_stamp or self.get_clock().now().to_msg()

    def _begin(self):
        """Start an episode."""
        self._pilot.reset()
        self._sensors.forget()
        self._trouble = self._refused = ''
        self._began = self._now()

    def _on_time_jump(self, _):
        """Simulated time went back: a new episode."""
        if self._active and not self._on_sensors:
            self._begin()

    def _on_reset(self, _, response):
        response.success = self._active
        if self._active:
            self._begin()
            response.message = 'the network starts afresh'
        else:
            response.message = 'the controller is not active'
        return response

    def _on_sensor(self, sensor, message):
        if not self._active:
            return
        try:
            self._sensors.take(sensor, message, self._now())
        except ValueError as error:
            self._refused = str(error)
            self._complaints.warn(f'message ignored: {error}')
            return
        if self._on_sensors:
            stamp = self._sensors.common_stamp()
            if stamp is not None:
                self._answered_stamp = stamp
                self._trouble = ''
                self._pilot.answer((stamp.sec, stamp.nanosec), self._sensors.readings)
                self._publish_command(stamp)

    def _on_timer(self):
        """Stop the robot when a sensor is silent; else, unless the sensors trigger steps, step."""
        if not self._active:
            return
        now = self._now()
        silent = self._sensors.silent(now, self._timeout)
        if silent:
            if now - self._began > self._timeout:
                self._stop_without(silent)
        elif not self._on_sensors:
            if self._trouble:
                self.get_logger().info('goes on: all sensors are back')
            self._trouble = ''
            self._pilot.step(self._sensors.readings)
            self._publish_command(self._stamp())

    def _stop_without(self, silent):
        """Stop the robot and say which sensors are missing; on the timer again and again."""
        first = not self._trouble
        self._trouble = f'no {" and no ".join(silent)} for {self._timeout:g} s'
        if self._refused:
            self._trouble += f' (last refused: {self._refused})'
        self._complaints.warn(f'robot stopped: {self._trouble}')
        if first or not self._on_sensors:
            self._pilot.stop()
            self._publish_command(self._stamp())

    def _publish_command(self, stamp):
        message = self._message
        twist = message
        if isinstance(message, TwistStamped):
            message.header.stamp = stamp
            twist = message.twist
        twist.linear.x, twist.angular.z = self._pilot.command
        self._command_publisher.publish(message)
        self._steps += 1
        if self._neurons_publisher.get_subscription_count():
            controller = self._pilot.controller
            neurons = np.concatenate([controller.inputs, controller.hidden, controller.outputs])
            self._neurons_publisher.publish(Float32MultiArray(data=array('f', neurons.tobytes())))

    def _report(self):
        """Tell on /diagnostics how the controller is."""
        level, text = DiagnosticStatus.OK, 'active' if self._active else 'not active'
        if self._active and self._trouble:
            level, text = DiagnosticStatus.ERROR, f'robot stopped: {self._trouble}'
        report = DiagnosticArray()
        report.header.stamp = self._stamp()
        report.status = [
            DiagnosticStatus(
                level=level,
                name=f'{self.get_fully_qualified_name().lstrip("/")}: network',
                message=text,
                hardware_id=self.get_namespace().strip('/'),
                values=[
                    KeyValue(key='commands sent', value=str(self._steps)),
                    KeyValue(key='last message refused', value=self._refused),
                ],
            )
        ]
        self._diagnostics.publish(report)


def main():
    """Run the node until it is stopped."""
    return run_node(ControllerNode)


if __name__ == '__main__':
    sys.exit(main())

"""The controller node: a lifecycle node that runs one genome on one robot."""

import sys
from dataclasses import fields

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TwistStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType, JumpThreshold
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.time import Time
from std_srvs.srv import Trigger

from marxbot_sensors import MARXBOT
from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import GENES
from neuro_controller.core.limits import Limits
from neuro_controller.core.pilot import PERIOD, Pilot
from neuro_controller.genome_client import GenomeClient
from neuro_controller.interface import (
    CONTROLLER,
    DIAGNOSTICS,
    NETWORK,
    NEURONS,
    QUEUE,
    SENSORS,
    command_topic,
)
from neuro_controller.sensors import Sensors
from neuro_controller.transitions import make_transitions_safe
from node_runner import Complaints, Concerns, run_node

LAST_WORD = 0.5
"""How long a node that ends waits for its robot to have heard the stop, s."""

MOST_RESTARTS = 5
"""So many sets of readings in a row that each begin an episode are a fault of their stamps."""


class ControllerNode(LifecycleNode):
    """Wraps `Pilot`; see the package's README for its topics, parameters and services."""

    def __init__(self):
        super().__init__('controller')
        CONTROLLER.declare(self)
        self._on_sensors = self._value('trigger') == 'sensors'
        self._timeout = self._value('sensor_timeout')
        # Compiled now, not at the first tick.
        Controller(np.zeros(GENES), 1.0).step(np.zeros(MARXBOT.readings))
        self._pilot = self._make_pilot({})
        self._sensors = Sensors(
            *map(self._value, ('contact_threshold', 'body_radius', 'stamp_tolerance'))
        )
        self._command_topic = command_topic(self._value('stamped_cmd_vel'))
        self._message = self._command_topic.type()
        self._neurons = NEURONS.type()
        self._complaints = Complaints(self.get_logger())
        self._active = False
        self._steps = self._restarts = 0
        self._trouble = self._refused = self._failure = ''
        self._command_publisher = self._neurons_publisher = self._timer = None
        self._sensor_subscriptions = []

        self._diagnostics = self.create_publisher(*_arguments(DIAGNOSTICS))
        self.create_service(Trigger, '~/reset', self._on_reset)
        make_transitions_safe(self, self._complaints)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._simulated = self._value('use_sim_time')
        self._step_clock = self.get_clock() if self._simulated else steady
        self.create_timer(1.0, self._report, clock=steady)
        self._jump_handle = self.get_clock().create_jump_callback(
            JumpThreshold(
                min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=False
            ),
            post_callback=self._on_time_jump,
        )
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        self._concerns = Concerns(self)
        self._find_genome()

    def _find_genome(self):
        """Ask the genome server, or start with the genome that is set, as the parameters say."""
        server, autostart = self._value('genome_server'), self._value('autostart')
        if server:
            if self._pilot is not None:
                raise ValueError('genome and genome_server are both set, expected one of them')
            names = [parameter.name for parameter in NETWORK]
            self._genome_client = GenomeClient(
                self, server, self._value('champion'), names, self._on_genome
            )
        elif autostart:
            if self._pilot is None:
                raise ValueError('genome is not set, expected it or genome_server with autostart')
            self._start()

    # Parameters

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
            **{parameter.name: value(parameter.name) for parameter in NETWORK},
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
        if names & {'genome', *(parameter.name for parameter in NETWORK)}:
            self._pilot = pilot
            self.get_logger().info(f'new network: {", ".join(sorted(names))} set')
        elif self._pilot is not None:
            self._pilot.limits = pilot.limits

    def _on_genome(self, genome, settings):
        """Take a genome and what it evolved with, but for what was set to something else."""
        server, champion = self._value('genome_server'), self._value('champion')
        values = {}
        for parameter in NETWORK:
            own, evolved = self._value(parameter.name), settings[parameter.name]
            if own == parameter.default:
                values[parameter.name] = evolved
            elif own != evolved:
                self.get_logger().warning(
                    f'{parameter.name} is {own}, in place of {evolved} with which {champion} of '
                    f'{server} evolved'
                )
        try:
            genes = Parameter('genome', Parameter.Type.DOUBLE_ARRAY, genome)
        except ValueError:
            self._refuse_genome(f'{champion!r} of {server} is {genome!r:.40}, expected a genome')
            return
        settings = [Parameter(name, value=value) for name, value in values.items()]
        result = self.set_parameters_atomically([genes, *settings])
        if not result.successful:
            self._refuse_genome(f'{champion!r} of {server} is refused: {result.reason}')
        elif self._value('autostart'):
            self._start()

    def _refuse_genome(self, sentence):
        self._refused = sentence
        self.get_logger().error(sentence)

    # Lifecycle

    def _start(self):
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def on_configure(self, state):
        """Open the robot's topics; fails without a genome."""
        if self._pilot is None:
            self.get_logger().error('cannot be configured: genome is not set')
            return TransitionCallbackReturn.FAILURE
        self._command_publisher = self.create_lifecycle_publisher(*_arguments(self._command_topic))
        self._neurons_publisher = self.create_lifecycle_publisher(*_arguments(NEURONS))
        self._sensor_subscriptions = [
            self.create_subscription(
                topic.type,
                topic.name,
                lambda message, sensor=topic.name: self._on_sensor(sensor, message),
                QUEUE if self._value('reliable_sensors') else topic.qos,
            )
            for topic in SENSORS
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
        self._close()
        return super().on_shutdown(state)

    def on_error(self, state):
        """After a transition that failed: be unconfigured again."""
        self._halt()
        self._close()
        return super().on_error(state)

    def on_failure(self, reason):
        """Stop the robot: a callback raised something."""
        self._failure = reason
        if self._active:
            self._stop(f'a callback failed with {reason}')

    def destroy_node(self):
        """Stop the robot before the process ends, and see that the robot has heard it."""
        if self._active:
            self._halt()
            self._command_publisher.wait_for_all_acked(Duration(seconds=LAST_WORD))
        super().destroy_node()

    def _halt(self):
        if self._active:
            self._active = False
            self._pilot.stop()
            self._publish_command(self.get_clock().now().to_msg())

    def _close(self):
        for subscription in self._sensor_subscriptions:
            self.destroy_subscription(subscription)
        self._sensor_subscriptions = []
        if self._timer is not None:
            self.destroy_timer(self._timer)
        for publisher in (self._command_publisher, self._neurons_publisher):
            if publisher is not None:
                self.destroy_lifecycle_publisher(publisher)
        self._command_publisher = self._neurons_publisher = self._timer = None

    # Steps

    def _now(self):
        return self._step_clock.now().nanoseconds * 1e-9

    def _begin(self):
        """Start an episode."""
        self._pilot.reset()
        self._sensors.forget()
        self._trouble = self._refused = ''
        self._restarts = 0
        self._began = self._completed_at = self._now()

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
        if not self._active or (self._simulated and self._concerns.without_clock):
            return
        try:
            self._sensors.take(sensor, message, self._now(), self.get_clock().now().nanoseconds)
        except ValueError as error:
            self._refused = str(error)
            self._complaints.warn(f'message ignored: {error}')
            return
        if self._on_sensors:
            stamp = self._sensors.complete_set()
            if stamp is not None:
                self._answer(stamp)

    def _answer(self, stamp):
        """Answer a set of readings of that time, ns."""
        begins = self._pilot.answer(stamp, self._sensors.readings)
        self._restarts = self._restarts + 1 if begins else 0
        self._completed_at = self._now()
        if self._restarts < MOST_RESTARTS:
            self._go_on()
            self._publish_command(Time(nanoseconds=stamp).to_msg())
        else:
            self._stop('the stamps of readings do not advance, so that all begin an episode')

    def _on_timer(self):
        """Stop the robot when a sensor is silent; else, unless the sensors trigger steps, step."""
        if not self._active:
            return
        now = self._now()
        silent = self._sensors.silent(now, self._timeout)
        if silent:
            if now - self._began > self._timeout:
                self._stop(f'no {" and no ".join(silent)} for {self._timeout:g} s')
        elif self._on_sensors:
            if now - self._completed_at > self._timeout:
                self._stop(
                    f'no complete set of readings for {self._timeout:g} s: '
                    f'{self._sensors.why_incomplete()}'
                )
        else:
            self._go_on()
            self._pilot.step(self._sensors.readings)
            self._publish_command(self.get_clock().now().to_msg())

    def _go_on(self):
        if self._trouble:
            self.get_logger().info('goes on')
            self._trouble = ''

    def _stop(self, reason):
        """Stop the robot and say why; on the timer again and again."""
        first = not self._trouble
        self._trouble = f'{reason} (last refused: {self._refused})' if self._refused else reason
        self._complaints.warn(f'robot stopped, {self._trouble}')
        if first or not self._on_sensors:
            self._pilot.stop()
            self._publish_command(self.get_clock().now().to_msg())

    def _publish_command(self, stamp):
        message = self._message
        twist = message
        if isinstance(message, TwistStamped):
            message.header.stamp = stamp
            twist = message.twist
        twist.linear.x, twist.angular.z = self._pilot.command
        self._command_publisher.publish(message)
        self._steps += 1
        controller, neurons = self._pilot.controller, self._neurons
        neurons.header.stamp = stamp
        neurons.inputs = controller.inputs
        neurons.hidden = controller.hidden
        neurons.outputs = controller.outputs
        self._neurons_publisher.publish(neurons)

    def _report(self):
        """Tell on /diagnostics how the controller is."""
        level, text = DiagnosticStatus.OK, 'active' if self._active else 'not active'
        if self._active and self._trouble:
            level, text = DiagnosticStatus.ERROR, f'robot stopped: {self._trouble}'
        elif self._concerns.sentences:
            level = DiagnosticStatus.WARN
        report = DiagnosticArray()
        report.header.stamp = self.get_clock().now().to_msg()
        report.status = [
            DiagnosticStatus(
                level=level,
                name=f'{self.get_fully_qualified_name().lstrip("/")}: network',
                message='; '.join([text, *self._concerns.sentences]),
                hardware_id=self.get_namespace().strip('/'),
                values=[
                    KeyValue(key='commands sent', value=str(self._steps)),
                    KeyValue(key='last message refused', value=self._refused),
                    KeyValue(key='last failure', value=self._failure),
                ],
            )
        ]
        self._diagnostics.publish(report)


def _arguments(topic):
    """Return what creates a publisher of a topic."""
    return topic.type, topic.name, topic.qos


def main():
    """Run the node until it is stopped."""
    return run_node(ControllerNode, CONTROLLER)


if __name__ == '__main__':
    sys.exit(main())

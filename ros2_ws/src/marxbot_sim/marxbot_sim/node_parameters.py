"""The simulator's parameters: names, defaults, checks."""

import math

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult

from marxbot_sim.core.fields import check_choice, options_of
from marxbot_sim.core.parameters import Arena
from marxbot_sim.core.perturbations import Perturbations

AT_END = ('pause', 'reset')
"""What the simulator may do when an episode ends."""

_PARAMETERS = {
    'physics': ('kinematic', "'kinematic' (exact motion, compiled) or 'pymunk' (rigid bodies)"),
    'lockstep': (False, 'make a tick when both robots have got their command, and only then'),
    'real_time_factor': (1.0, 'simulated over real time, outside lockstep; can be set live'),
    'paused': (False, 'start paused'),
    'episode_ticks': (0, 'ticks of 0.1 s after which an episode ends; 0: only a capture does'),
    'at_end': ('pause', "what to do when an episode ends: 'pause', or 'reset' to start another"),
    'stamped_cmd_vel': (False, 'take TwistStamped on cmd_vel instead of Twist'),
    'cmd_vel_timeout': (0.5, 's of simulated time without a command that stop a robot'),
    'max_wheel_speed': (10.0, 'fastest a wheel can turn, rad/s; faster commands are slowed down'),
}
_GROUPS = {'arena': Arena, 'perturbations': Perturbations}
_POSITIVE = ('real_time_factor', 'cmd_vel_timeout', 'max_wheel_speed')


class Parameters:
    """The parameters of the simulator node, declared from their one source of defaults.

    Parameters
    ----------
    node : rclpy.node.Node
    on_pace : callable
        Called with a new real-time factor that was set live.
    on_perturbations : callable
        Called with new `Perturbations` that were set live.

    Raises
    ------
    ValueError
        A value is out of its range.
    """

    def __init__(self, node, on_pace, on_perturbations):
        self._node = node
        self._on_pace = on_pace
        self._on_perturbations = on_perturbations
        for name, (default, text) in _PARAMETERS.items():
            self._declare(name, default, text, live=name == 'real_time_factor')
        for group, kind in _GROUPS.items():
            for name, option in options_of(kind).items():
                unit = f', {option.unit}' if option.unit else ''
                live = group == 'perturbations'
                self._declare(f'{group}.{name}', option.default, option.help + unit, live)
        check_choice('at_end', self['at_end'], AT_END)
        if self['episode_ticks'] < 0:
            raise ValueError(f'episode_ticks is {self["episode_ticks"]}, expected 0 or more')
        for name in _POSITIVE:
            _check_positive(name, self[name])
        node.add_on_set_parameters_callback(self._on_set)

    def _declare(self, name, default, text, live):
        descriptor = ParameterDescriptor(description=text, read_only=not live)
        self._node.declare_parameter(name, default, descriptor)

    def __getitem__(self, name):
        return self._node.get_parameter(name).value

    def group(self, name, changes=None):
        """Return the object that a group of parameters, 'arena' or 'perturbations', describes."""
        kind = _GROUPS[name]
        values = {field: self[f'{name}.{field}'] for field in options_of(kind)}
        return kind(**values | (changes or {}))

    def _on_set(self, parameters):
        """Take a new pace or new perturbations, all or nothing."""
        changes = {
            parameter.name.removeprefix('perturbations.'): parameter.value
            for parameter in parameters
            if parameter.name.startswith('perturbations.')
        }
        factors = [p.value for p in parameters if p.name == 'real_time_factor']
        try:
            perturbations = self.group('perturbations', changes)
            for factor in factors:
                _check_positive('real_time_factor', factor)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if changes:
            self._on_perturbations(perturbations)
        for factor in factors:
            self._on_pace(factor)
        return SetParametersResult(successful=True)


def _check_positive(name, value):
    if not 0 < value < math.inf:
        raise ValueError(f'{name} is {value}, expected a finite number above 0')

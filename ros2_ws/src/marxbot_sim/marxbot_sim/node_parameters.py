"""The simulator's parameters: declared from its interface, checked, and taken when set live."""

from rcl_interfaces.msg import SetParametersResult

from marxbot_sim.core.fields import options_of
from marxbot_sim.core.parameters import ROBOTS, Arena
from marxbot_sim.core.perturbations import Perturbations
from marxbot_sim.interface import SIMULATOR

_GROUPS = {'arena': Arena, 'perturbations': Perturbations}


class Parameters:
    """The parameters of the simulator node.

    Parameters
    ----------
    node : rclpy.node.Node
    on_pace : callable
        Called with a new real-time factor that was set live.
    on_perturbations : callable
        Called with new `Perturbations` that were set live.
    on_numbers : callable
        Called with two numbers of episodes that were set live, each from 0 to 2**64 - 1.

    Raises
    ------
    ValueError
        A value is out of its range.
    """

    def __init__(self, node, on_pace, on_perturbations, on_numbers):
        self._node = node
        self._on_pace = on_pace
        self._on_perturbations = on_perturbations
        self._on_numbers = on_numbers
        SIMULATOR.declare(node)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def __getitem__(self, name):
        return self._node.get_parameter(name).value

    def group(self, name, changes=None):
        """Return the object that a group of parameters, 'arena' or 'perturbations', describes."""
        kind = _GROUPS[name]
        values = {field: self[f'{name}.{field}'] for field in options_of(kind)}
        return kind(**values | (changes or {}))

    def _check(self, parameters):
        changes = {
            parameter.name.removeprefix('perturbations.'): parameter.value
            for parameter in parameters
            if parameter.name.startswith('perturbations.')
        }
        try:
            self.group('perturbations', changes)
            for parameter in parameters:
                if parameter.name == 'episode_numbers' and len(parameter.value) != len(ROBOTS):
                    raise ValueError(
                        f'episode_numbers has {len(parameter.value)} numbers, expected 2, of '
                        'predator and prey'
                    )
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take(self, parameters):
        names = [parameter.name for parameter in parameters]
        if any(name.startswith('perturbations.') for name in names):
            self._on_perturbations(self.group('perturbations'))
        if 'real_time_factor' in names:
            self._on_pace(self['real_time_factor'])
        if 'episode_numbers' in names:
            self._on_numbers(tuple(number % 2**64 for number in self['episode_numbers']))

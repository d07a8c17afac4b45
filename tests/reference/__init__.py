"""The whole episode once more, in plain float64 NumPy.

Written from the paper (appendix A1-A3) and the description of the model, never from the kernels,
and for the eye rather than for speed: whatever the compiled code does must agree with this. Every
function works on a batch: ``n`` independent pairs, robot 0 = predator, 1 = prey, SI units.
"""

from reference.controller import decide, wheel_commands
from reference.episode import Model, State, behave, play
from reference.motion import arc, gap, press
from reference.sensing import sense

__all__ = [
    'Model',
    'State',
    'arc',
    'behave',
    'decide',
    'gap',
    'play',
    'press',
    'sense',
    'wheel_commands',
]

"""What sensors beyond those of a MarxBot read: each brings its own part of the kernel."""

from numba.extending import overload

from marxbot_sensors import Robot
from simd_lanes import INLINED, compile_for, kernel_part, source_stamp


def _text(robot):
    """Return what tells robots apart: their sensors, and the sources of what computes these."""
    return f'{robot!r} {[source_stamp(sensor.sense) for sensor in robot.further]}'


compile_for(Robot, _text)


def sense_further(robot, bodies, arena, readings):
    """Fill what the further sensors of a robot read; in kernels, one part for each of them."""
    for sensor in robot.further:
        sensor.sense(bodies, arena, robot.rows(sensor).start, readings)


@overload(sense_further, jit_options=INLINED)  # type: ignore[arg-type]
def _sense_further(robot, bodies, arena, readings):
    part = _nothing
    for sensor in robot.value.further:
        part = _both(part, sensor.sense, robot.value.rows(sensor).start)
    return lambda robot, bodies, arena, readings: part(bodies, arena, readings)


@kernel_part
def _nothing(bodies, arena, readings):
    pass


def _both(part, sense, first):
    @kernel_part
    def both(bodies, arena, readings):
        part(bodies, arena, readings)
        sense(bodies, arena, first, readings)

    return both

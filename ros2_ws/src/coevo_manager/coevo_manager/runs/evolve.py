"""The executable evolve: co-evolution from the command line."""

from __future__ import annotations

import os
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import rclpy

from coevo_manager.command_line import refuse
from coevo_manager.core.evolution import RunFolderError
from coevo_manager.evaluators.roster import EvaluationError
from coevo_manager.outlet import make_console
from coevo_manager.runs.display import PlainDisplay, make_display
from coevo_manager.runs.options import Options, read_options
from coevo_manager.runs.page import Page
from coevo_manager.runs.run import Plan, Runner, make_plan
from coevo_manager.runs.status import Status
from coevo_manager.runs.template import make_template
from node_runner import complain, own_arguments, start_ros


class _Interruption:
    """Signals that ask the run to end; they are kept until there is a run that can be asked."""

    def __init__(self) -> None:
        self.received: list[int] = []
        self._stop: Callable[[], None] | None = None
        signals = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
        self._former = {number: signal.signal(number, self._receive) for number in signals}

    def _receive(self, number: int, _: object) -> None:
        self.received.append(number)
        if self._stop is not None:
            self._stop()

    def pass_on(self, stop: Callable[[], None]) -> None:
        """Call `stop` at each signal from now on, and now if one came before."""
        self._stop = stop
        if self.received:
            stop()

    def restore(self) -> None:
        """Let the signals do what they did before."""
        for number, handler in self._former.items():
            signal.signal(number, handler)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the executable ``evolve``.

    Returns
    -------
    int
        Exit code: 0 when the run is complete, 2 for bad input, 1 when it failed, and 128 and the
        signal's number when a signal ended it.
    """
    command_line = list(sys.argv if arguments is None else ['evolve', *arguments])
    try:
        options = read_options(own_arguments(command_line))
        if options.print_config:
            print(make_template(options.values, options.preset), end='')
            return 0
    except (ValueError, OSError) as error:
        return refuse('evolve', error)
    interruption = _Interruption()  # before there is a folder that would be left behind
    try:
        plan = make_plan(options.values, options.preset, options.out, options.resume)
    except (ValueError, OSError) as error:
        interruption.restore()
        return refuse('evolve', error)
    # Events are shown by the display; rosout and the log file get them as well.
    start_ros([*command_line, '--ros-args', '--disable-stdout-logs'])
    try:
        return _evolve(plan, options, interruption)
    finally:
        rclpy.try_shutdown()


def _evolve(plan: Plan, options: Options, interruption: _Interruption) -> int:
    try:
        node = rclpy.create_node('evolve', start_parameter_services=False)
    except RuntimeError as error:
        complain(['evolve'], error)
        return 1
    console = make_console()
    display = make_display(plan.configuration, options.quiet, console)
    # The address was asked for: --quiet silences what a run tells of itself.
    tell = PlainDisplay(plan.configuration, console).event if options.quiet else display.event
    page = Page(plan.folder, tell) if options.dashboard else None

    def show(status: Status) -> None:
        if page is not None:
            page.open()
        display.status(status)

    run = Runner(
        node,
        plan,
        show,
        display.event,
        options.evaluators,
        options.patience,
        display.wait,
    )
    interruption.pass_on(run.stop)
    try:
        with display:
            display.event(f'evolving into {plan.folder}')
            for note in plan.notes:
                display.event(note)
            outcome = run.run()
    except EvaluationError as error:
        return refuse('evolve', error)
    except RunFolderError as error:
        print(f'evolve: {error}', file=sys.stderr)
        return 1
    finally:
        node.destroy_node()
        if page is not None:
            page.close()
    if outcome.finished:
        display.report(outcome.report)
        display.event(f'The run is in {outcome.folder}')
        return 0
    if (outcome.folder / 'run.json').exists():
        display.event('stopped; this goes on:')
        display.event(_resuming(outcome.folder))
    else:
        display.event('stopped before the run began')
    return 128 + interruption.received[0]


def _resuming(folder: Path) -> str:
    """Return the command that goes on with the run in a folder, to be pasted."""
    ros2 = os.environ.get('ROS2_COMMAND', 'ros2')
    return shlex.join([ros2, 'run', 'coevo_manager', 'evolve', '--resume', str(folder)])


if __name__ == '__main__':
    sys.exit(main())

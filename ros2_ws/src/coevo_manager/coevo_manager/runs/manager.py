"""The manager node: evolution as an action."""

from __future__ import annotations

import reprlib
import sys
from pathlib import Path
from typing import Any

from coevo_msgs.action import Evolve
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from coevo_manager.core.documents import parse_document
from coevo_manager.core.evolution import GenerationStats, RunFolderError
from coevo_manager.evaluators.roster import EvaluationError
from coevo_manager.runs.run import Plan, Runner, make_plan, to_message
from coevo_manager.runs.status import Status
from node_runner import Concerns, Interface, Parameter, Service, run_node
from node_runner.actions import GoalServer

MANAGER = Interface(
    'coevo_manager manager',
    'runs evolution, one run at a time.',
    (
        Parameter(
            'evaluators',
            -1,
            'evaluator processes to start for a run; 0: use running ones; -1: one for each core',
            low=-1,
            high=1024,
            live=True,
        ),
        Parameter(
            'patience',
            5.0,
            'shortest time after which an evaluator counts as late, s',
            low=0.1,
            high=86400.0,
            live=True,
        ),
    ),
    actions=(Service('evolve', Evolve, 'starts or resumes a run'),),
)


class ManagerNode(Node):
    """Serves the action ``evolve`` (coevo_msgs/action/Evolve), one run at a time.

    Bad goals are aborted with one sentence in the result, as are failed runs; a cancelled run ends
    within a generation and its folder can be resumed.
    """

    def __init__(self) -> None:
        super().__init__('manager')
        MANAGER.declare(self)
        self._run: Runner | None = None
        self._server = GoalServer(
            self,
            Evolve,
            'evolve',
            self._evolve,
            'a run is in progress; cancel it or wait for its end',
            self.stop,
        )
        self._concerns = Concerns(self)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    @property
    def busy(self) -> bool:
        """Whether a run is in progress."""
        return self._server.busy

    def stop(self) -> None:
        """Ask the run in progress, if any, to end within a generation."""
        if self._run is not None:
            self._run.stop()

    def _evolve(self, goal: ServerGoalHandle, result: Evolve.Result) -> None:
        """Fill the result; called in the run's thread."""
        # The run waits for its clients by itself, so they must not be this node's, which is spun.
        node = Node('evolution', start_parameter_services=False)
        try:
            plan = _read_goal(goal.request)
            evaluators, patience = map(self._value, ('evaluators', 'patience'))
            self._run = Runner(
                node,
                plan,
                lambda status: _tell(status, goal, result),
                lambda message: None,
                None if evaluators < 0 else evaluators,
                patience,
            )
            if goal.is_cancel_requested:
                self._run.stop()
            result.path = str(plan.folder)
            outcome = self._run.run()
            result.success = outcome.finished
            if not outcome.finished:
                result.message = f'stopped on request; go on by resuming {outcome.folder}'
        except (ValueError, RunFolderError, EvaluationError) as error:
            result.message = str(error)
        except Exception as error:
            result.message = f'{type(error).__name__}: {error}'
            self.get_logger().error(result.message)
        finally:
            self._run = None
            node.destroy_node()


def _tell(status: Status, goal: ServerGoalHandle, result: Evolve.Result) -> None:
    stats = status.stats
    result.generations, result.phases = stats.generation, stats.phase
    result.episodes, result.ticks = stats.episodes, stats.ticks
    if isinstance(stats, GenerationStats):
        result.phases -= 1  # the running one is not completed
        goal.publish_feedback(Evolve.Feedback(stats=to_message(status)))


def _read_goal(request: Evolve.Goal) -> Plan:
    folder = Path(request.out) if request.out else None
    if request.resume and (folder is None or request.configuration):
        raise ValueError(
            'out is empty or configuration given, expected the folder alone in a goal that resumes'
        )
    try:
        values: Any = parse_document(request.configuration) or {}
    except ValueError as error:
        raise ValueError(f'configuration is neither JSON nor YAML: {error}') from None
    if not isinstance(values, dict):
        raise ValueError(f'configuration is {reprlib.repr(values)}, expected a mapping')
    if request.resume:
        return make_plan({}, request.preset, None, folder)
    return make_plan(values, request.preset, folder, None)


def main() -> int:
    """Run the executable ``manager`` until it is stopped; return its exit code."""
    return run_node(ManagerNode, MANAGER)


if __name__ == '__main__':
    sys.exit(main())

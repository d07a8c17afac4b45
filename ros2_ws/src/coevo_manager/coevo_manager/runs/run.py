"""One run of evolution on a ROS node: its evaluators, its statistics, its events."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import os
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from coevo_msgs.msg import GenerationStats as GenerationStatsMsg
from rclpy.duration import Duration
from rclpy.node import Node

from coevo_manager.core.configuration import Configuration, differences
from coevo_manager.core.evaluation import StoppedError
from coevo_manager.core.evolution import (
    Evolution,
    GenerationStats,
    Outcome,
    PhaseStats,
    RunFolderError,
    algorithms,
    check_new_folder,
    load_configuration,
    read_configuration,
    remarks,
)
from coevo_manager.core.evolution.checkpoint import find_sound
from coevo_manager.core.evolution.sessions import remark_on_program
from coevo_manager.evaluators.pool import RosEvaluator
from coevo_manager.runs.status import STATUS_PERIOD, Pace, Status, StatusFile

DISCOVERY_TIMEOUT = 10.0
"""How long a run without own evaluators looks for the first one, s."""

LAST_PATIENCE = 10.0
"""How long the last statistics are offered to subscribers that have not confirmed them, s, ..."""

STOP_PATIENCE = 0.5
"""... and where the run was asked to stop."""

SLOW_START = 3.0
"""A start of the evaluators that takes longer is explained, s."""


@dataclasses.dataclass(frozen=True)
class Plan:
    """What to run and where.

    Attributes
    ----------
    configuration : Configuration
    folder : Path
        The run folder.
    resume : bool
        Whether to go on with the run that the folder holds.
    made : bool
        Whether the folder was made for this plan; it goes again if the run does not begin.
    notes : tuple of str
        Of the run that goes on: what was found damaged and is passed over, and another program.
    """

    configuration: Configuration
    folder: Path
    resume: bool
    made: bool = False
    notes: tuple[str, ...] = ()


def make_plan(
    values: Mapping[str, Any], preset: str, out: Path | None, resume: Path | None
) -> Plan:
    """Decide what to run, checking all that can be checked beforehand.

    Parameters
    ----------
    values : mapping
        Fields of `Configuration` by name; with `resume`, they must be those of the run.
    preset : str
        What they change; without meaning with `resume`.
    out : Path, optional
        The folder of a new run; without it, the first ``runs/<algorithm>-<seed>-<number>`` that
        is free.
    resume : Path, optional
        The folder of the run to go on with.

    Raises
    ------
    ValueError, RunFolderError
        One sentence.
    OSError
        The folder of a new run cannot be made.
    """
    if resume is not None:
        held = read_configuration(resume)
        wanted = load_configuration(held.as_dict() | dict(values))
        if wanted != held:
            raise RunFolderError(
                f'{resume} holds a run of another configuration '
                f'(there, here): {"; ".join(differences(held, wanted))}'
            )
        notes: list[str] = []
        find_sound(resume, held, algorithms.load(held.algorithm)(held), notes.append)
        if remark := remark_on_program(resume):
            notes.append(remark)
        return Plan(held, resume, resume=True, notes=tuple(notes))
    configuration = load_configuration(values, preset)
    if out is None:
        folder = _make_folder(f'{configuration.algorithm}-{configuration.seed}')
        return Plan(configuration, folder, resume=False, made=True)
    check_new_folder(out)
    return Plan(configuration, out, resume=False)


def _make_folder(stem: str) -> Path:
    """Make the first folder that is free, which makes it this process's own."""
    Path('runs').mkdir(exist_ok=True)
    for number in itertools.count(1):
        folder = Path('runs', f'{stem}-{number}')
        with contextlib.suppress(FileExistsError):
            folder.mkdir()
            break
    return folder


class Runner:
    """Runs a plan; the evaluators are started and ended with it.

    Parameters
    ----------
    node : Node
        It must not be spun. It publishes ``generation_stats`` (coevo_msgs/GenerationStats) at most
        10 times a second, and tells events on /rosout.
    plan : Plan
    on_status : callable
        Called with a `Status`, at most 10 times a second and after each phase.
    on_event : callable
        Called with one sentence when something happens.
    on_wait : callable, optional
        Called with what the run waits for before it begins.
    own_evaluators : int, optional
        Evaluator processes to start; 0: use running ones. Without it, one for each core.
    patience : float
        The shortest time after which an evaluator counts as late, s.
    """

    def __init__(
        self,
        node: Node,
        plan: Plan,
        on_status: Callable[[Status], None],
        on_event: Callable[[str], None],
        own_evaluators: int | None = None,
        patience: float = 5.0,
        on_wait: Callable[[str], None] = lambda what: None,
    ) -> None:
        self._node = node
        self._on_wait = on_wait
        self._plan = plan
        self._on_status = on_status
        self._on_event = on_event
        self._stop = threading.Event()
        self._evolution: Evolution | None = None
        self._pace = Pace()
        self._next_status = 0.0
        self._untold: GenerationStats | None = None
        self._publisher = node.create_publisher(GenerationStatsMsg, 'generation_stats', 10)
        if own_evaluators is None:
            own_evaluators = len(os.sched_getaffinity(0))
        self._own_evaluators = own_evaluators
        self._evaluator = RosEvaluator(
            node, plan.configuration.make_environment(), own_evaluators, self._event, patience
        )
        self._status_file = StatusFile(plan.folder, self._evaluator.describe)

    def run(self) -> Outcome:
        """Run to the end, or till `stop` is called.

        Raises
        ------
        RunFolderError
            The folder cannot be used or written.
        EvaluationError
            There is no evaluator to play the episodes.
        """
        plan = self._plan
        explanation = threading.Timer(SLOW_START, self._explain_start)
        try:
            explanation.start()
            own = self._own_evaluators
            self._on_wait('starting the evaluators' if own else 'looking for evaluators')
            self._evaluator.start(self._stop, None if self._own_evaluators else DISCOVERY_TIMEOUT)
            explanation.cancel()
            if plan.resume:
                self._evolution = Evolution.resume(plan.folder, self._evaluator, self._observe)
            else:
                self._evolution = Evolution(
                    plan.configuration, self._evaluator, plan.folder, self._observe
                )
            for remark in remarks(plan.configuration, plan.configuration.phases):
                self._on_event(remark)
            if self._stop.is_set():
                self._evolution.stop()
            return self._evolution.run()
        except StoppedError:
            return Outcome(finished=False, folder=plan.folder, report='')
        finally:
            explanation.cancel()
            if plan.made:
                with contextlib.suppress(OSError):  # it is not empty: the run began
                    plan.folder.rmdir()
            self._evaluator.close()
            patience = STOP_PATIENCE if self._stop.is_set() else LAST_PATIENCE
            self._publisher.wait_for_all_acked(Duration(seconds=patience))
            self._node.destroy_publisher(self._publisher)

    def stop(self) -> None:
        """Ask the run to end within a generation; from any thread or a signal handler."""
        self._stop.set()
        if self._evolution is not None:
            self._evolution.stop()

    def _explain_start(self) -> None:
        if self._own_evaluators:
            self._on_wait('the evaluators compile the simulation, which the first start has to')

    def _event(self, message: str) -> None:
        if self._evolution is not None:
            self._evolution.log(message)
        self._node.get_logger().info(message)
        self._on_event(message)

    def _observe(self, stats: GenerationStats | PhaseStats) -> None:
        now = time.monotonic()
        if isinstance(stats, GenerationStats):
            if now < self._next_status:
                self._untold = stats
                return
            self._tell(stats, now)
        else:
            if self._untold is not None:
                self._tell(self._untold, now)
            self._show(self._pace.status(stats, now))

    def _tell(self, stats: GenerationStats, now: float) -> None:
        self._next_status = now + STATUS_PERIOD
        self._untold = None
        status = self._pace.status(stats, now)
        message = to_message(status)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
        self._show(status)

    def _show(self, status: Status) -> None:
        self._status_file.write(status)
        self._on_status(status)


def to_message(status: Status) -> GenerationStatsMsg:
    """Return the message of a generation's status, without its time."""
    names = GenerationStatsMsg.get_fields_and_field_types()
    fields = {k: v for k, v in dataclasses.asdict(status.stats).items() if k in names}
    return GenerationStatsMsg(
        **fields, ticks_per_second=status.ticks_per_second, seconds_left=status.seconds_left
    )

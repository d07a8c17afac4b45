"""Evaluators that stop, hang and lie: the run says so, and its files are as without them."""

import re
import signal
import sys

import pytest
from evolve_runs import TOY, evaluators_of, read_files, toy_files
from ros_processes import has_ended, wait_until

HOSTILE = """
import os, signal, sys, threading
import numpy as np, rclpy
from coevo_manager.evaluators.evaluator import EvaluatorNode
from coevo_manager.evaluators.messages import to_sequence

class Hostile(EvaluatorNode):
    honest = {honest}
    known = None  # the first answer: of the episodes that evaluators are compared by

    def _respond(self, response, task):
        ticks = np.array(response.capture_ticks, np.int32)
        if self.known is None:
            self.known = ticks
        if self.honest > 0:
            self.honest -= 1
        else:
            {lie}
            response.capture_ticks = to_sequence(ticks.astype(np.int32), 'i')
        super()._respond(response, task)

rclpy.init(args=sys.argv)
signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
Hostile().serve(threading.Event())
"""
LIES = {
    'huge': ('ticks[:] = 2**31 - 1', 'answered tick 2147483647, expected 1 to 400'),
    'negative': ('ticks[-1] = -5', 'answered tick -5, expected 1 to 400'),
    'short': ('ticks = ticks[:-1]', r'answered \d+ episodes of \d+'),
    'sulking': (
        "response.success, response.message = False, 'no mood'",
        'refused its work: no mood',
    ),
    'plausible': (  # now and then the known episodes are asked again
        'ticks = ticks if np.array_equal(ticks, self.known) else ticks % 399 + 1',
        r'answered tick \d+ for an episode that ends at tick \d+',
    ),
}


@pytest.fixture(scope='module')
def toy(tmp_path_factory):
    """The files of the toy run, played in this process."""
    return toy_files(tmp_path_factory.mktemp('toy') / 'run')


@pytest.fixture
def start_hostile(start):
    """``start_hostile(lies, honest)``: evaluators, by name, that lie after `honest` answers."""

    def start_all(lies, honest=1):
        started = [
            start(
                [
                    *(sys.executable, '-c', HOSTILE.format(lie=lie, honest=honest)),
                    *('--ros-args', '-r', f'__ns:=/{name}'),
                ]
            )
            for name, lie in lies.items()
        ]
        for process in started:
            process.wait_for_output('ready on')
        return started

    return start_all


@pytest.mark.timeout(600)
def test_who_answers_badly_is_refused_and_changes_nothing(start, start_hostile, tmp_path, toy):
    out = tmp_path / 'run'
    liars = start_hostile({name: lie for name, (lie, _) in LIES.items()})
    run = start(['coevo_manager', 'evolve', *TOY, '--evaluators', '--out', out])
    for name, (_, sentence) in LIES.items():
        wait_until(
            lambda name=name, sentence=sentence: re.search(
                f'evaluator /{name}/evaluate_batch is refused: it {sentence}', run.stdout_text
            ),
            f'the refusal of the {name} one',
            120,
        )
    run.wait_for_output('no evaluator is left')
    start(['coevo_manager', 'evaluator', '--ros-args', '-r', '__ns:=/honest'])
    assert run.wait(150) == 0, run.stderr_text
    assert all(liar.poll() is None for liar in liars)
    log = (out / 'run.log').read_text()
    assert 'evaluator /honest/evaluate_batch joined' in log
    assert read_files(out) == toy


def test_a_liar_beside_own_evaluators_gets_no_further(start, start_hostile, tmp_path, toy):
    out = tmp_path / 'run'
    start_hostile({'late_liar': LIES['plausible'][0]}, honest=4)
    run = start(['coevo_manager', 'evolve', *TOY, '--evaluators', '1', '--out', out])
    assert run.wait(150) == 0, run.stderr_text
    log = (out / 'run.log').read_text()
    if 'late_liar/evaluate_batch joined' in log and 'is refused' in log:
        assert re.search(r'late_liar\S+ is refused: it (answered tick|plays known)', log), log
    assert read_files(out) == toy


@pytest.mark.timeout(600)
def test_an_evaluator_that_is_stopped_while_it_starts_holds_up_nobody(start, tmp_path, toy):
    out = tmp_path / 'run'
    run = start(['coevo_manager', 'evolve', *TOY, '--evaluators', '2', '--out', out])
    wait_until(lambda: evaluators_of(run.pid), 'the first evaluator')
    (first,) = evaluators_of(run.pid)
    first.send_signal(signal.SIGSTOP)
    other = start(['coevo_manager', 'evolve', *TOY, '--out', tmp_path / 'other'])
    assert other.wait(150) == 0, other.stderr_text
    assert run.wait(150) == 0, run.stderr_text
    assert 'is late and was ended' in run.stdout_text
    assert has_ended(first)
    assert read_files(out) == read_files(tmp_path / 'other') == toy


def test_evaluators_end_with_a_killed_run_even_if_they_are_stopped(start, tmp_path):
    run = start(['coevo_manager', 'evolve', *TOY, '--evaluators', '1', '--out', tmp_path / 'run'])
    wait_until(lambda: evaluators_of(run.pid), 'the first evaluator')
    (first,) = evaluators_of(run.pid)
    first.send_signal(signal.SIGSTOP)
    run.kill()
    wait_until(lambda: has_ended(first), 'the end of the evaluator')

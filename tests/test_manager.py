"""The Evolve action, asked by a real action client."""

import time

import pytest
import yaml
from action_msgs.msg import GoalStatus
from coevo_msgs.action import Evolve
from evolve_runs import read_files
from ros_client import GoalClient
from unique_identifier_msgs.msg import UUID

TOY = {'population': 8, 'selected': 4, 'generations': 5, 'episode_ticks': 200}


@pytest.fixture(scope='module')
def manager(starter, client):
    """An `Asker` of a real manager."""
    process = starter(['coevo_manager', 'manager', '--ros-args', '-p', 'evaluators:=1'])
    yield Asker(client)
    process.terminate()
    assert process.wait() == 0
    assert 'Traceback' not in process.stderr_text


class Asker:
    """A client of the action."""

    def __init__(self, client):
        self.ros = client
        self.action = GoalClient(client, Evolve, 'evolve')
        self.feedback = []

    def send(self, **fields):
        self.feedback.clear()
        return self.action.send(
            Evolve.Goal(**fields), lambda message: self.feedback.append(message.feedback.stats)
        )

    def run(self, **fields):
        return self.action.result(self.send(**fields))


def configuration(**values):
    return yaml.safe_dump(TOY | values)


def test_a_goal_runs_to_its_end(manager, tmp_path):
    answer = manager.run(out=str(tmp_path / 'a'), configuration=configuration(phases=3))
    result = answer.result
    assert answer.status == GoalStatus.STATUS_SUCCEEDED
    assert result.success
    assert result.message == ''
    assert (result.path, result.generations, result.phases) == (str(tmp_path / 'a'), 15, 3)
    assert result.episodes == 8 * 8 + 3 * (5 * 4 * 4 + 4 * 8)
    assert result.ticks > 0
    assert manager.feedback[-1].generation == 15
    assert manager.feedback[-1].progress == 1
    assert (tmp_path / 'a' / 'report.md').exists()


def test_a_cancelled_run_can_be_resumed(manager, tmp_path):
    whole, cut = tmp_path / 'whole', tmp_path / 'cut'
    wanted = configuration(phases=150, seed=4)
    goal = manager.send(out=str(cut), configuration=wanted)
    manager.ros.until(
        lambda: manager.feedback and manager.feedback[-1].phase > 2, 'the third phase'
    )
    asked = time.monotonic()
    manager.action.cancel(goal)
    answer = manager.action.result(goal)
    assert answer.status == GoalStatus.STATUS_CANCELED
    assert time.monotonic() - asked < 10
    assert 0 < answer.result.phases < 150
    assert not answer.result.success
    assert f'resuming {cut}' in answer.result.message
    assert manager.run(out=str(cut), resume=True).result.success
    assert manager.run(out=str(whole), configuration=wanted).result.success
    assert read_files(cut) == read_files(whole)


def test_a_goal_that_is_sent_again_is_accepted_again_and_run_once(manager, tmp_path):
    goal = Evolve.Goal(out=str(tmp_path / 'a'), configuration=configuration(phases=2))
    goal_id = UUID(uuid=list(b'sent three times'))
    futures = [manager.action.send_goal_async(goal, None, goal_id) for _ in range(3)]
    manager.ros.until(lambda: all(future.done() for future in futures), 'three answers')
    handles = [future.result() for future in futures]
    assert all(handle.accepted for handle in handles)
    assert handles[0].stamp == handles[1].stamp == handles[2].stamp
    answer = manager.action.result(handles[0])
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    again = manager.ros.answer(
        lambda: manager.action.send_goal_async(goal, None, goal_id), 'an answer after the end'
    )
    assert again.accepted
    assert manager.action.result(again).result == answer.result


def test_one_run_at_a_time(manager, tmp_path):
    goal = manager.send(out=str(tmp_path / 'a'), configuration=configuration(phases=10_000))
    answer = manager.run(out=str(tmp_path / 'b'), configuration=configuration(phases=1))
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert 'a run is in progress' in answer.result.message
    assert not (tmp_path / 'b').exists()
    manager.action.cancel(goal)
    assert manager.action.result(goal).status == GoalStatus.STATUS_CANCELED


@pytest.mark.parametrize(
    ('fields', 'sentence'),
    [
        (
            {'configuration': '{populaton: 3}'},
            'configuration key populaton is unknown, expected some of',
        ),
        ({'configuration': '{population: -3}'}, 'population is -3, expected a whole number'),
        ({'configuration': '[1, 2]'}, 'configuration is [1, 2], expected a mapping'),
        ({'configuration': '{a: '}, 'configuration is neither JSON nor YAML'),
        ({'preset': 'slow'}, "preset is 'slow', expected one of quick, paper"),
        ({'resume': True}, 'expected the folder alone in a goal that resumes'),
        ({'resume': True, 'out': '/nowhere'}, '/nowhere holds no run'),
        ({'out': '/proc/version'}, '/proc/version'),
    ],
)
def test_bad_goals_are_aborted_with_one_sentence(manager, fields, sentence):
    answer = manager.run(**fields)
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert not answer.result.success
    assert sentence in answer.result.message
    assert '\n' not in answer.result.message


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['-p', 'evaluators:=-3'], 'evaluators is -3, expected a number from -1 to 1024'),
        (['-p', 'patience:=soon'], 'patience'),
        (['-r', 'nothing'], "remap rule: '-r nothing'"),
    ],
)
def test_bad_arguments_are_refused(start, arguments, sentence):
    process = start(['coevo_manager', 'manager', '--ros-args', *arguments])
    assert process.wait() == 2
    assert sentence in process.stderr_text
    assert 'Traceback' not in process.stderr_text

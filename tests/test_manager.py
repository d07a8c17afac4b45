"""The Evolve action, asked by a real action client."""

import time

import pytest
import rclpy
import yaml
from action_msgs.msg import GoalStatus
from coevo_msgs.action import Evolve
from evolve_runs import read_files
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from ros_processes import process_starter, ros_environment

from node_runner import settle

TOY = {'population': 8, 'selected': 4, 'generations': 5, 'episode_ticks': 200}


@pytest.fixture(scope='module')
def manager(tmp_path_factory):
    """An `Asker` of a real manager."""
    folder = tmp_path_factory.mktemp('manager')
    with ros_environment() as env, process_starter(env, folder) as start:
        process = start(['coevo_manager', 'manager', '--ros-args', '-p', 'evaluators:=1'])
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=int(env['ROS_DOMAIN_ID']))
        asker = Asker(context)
        try:
            assert asker.client.wait_for_server(60)
            settle(asker.executor)
            yield asker
            process.terminate()
            assert process.wait(10) == 0
            assert 'Traceback' not in process.stderr_text
        finally:
            asker.executor.shutdown()
            asker.node.destroy_node()
            rclpy.shutdown(context=context)


class Asker:
    """A client of the action."""

    def __init__(self, context):
        self.node = rclpy.create_node('asker', context=context)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.client = ActionClient(self.node, Evolve, 'evolve')
        self.feedback = []

    def wait(self, condition, timeout=60):
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline
            self.executor.spin_once(timeout_sec=0.1)

    def result_of(self, future):
        self.wait(future.done)
        return future.result()

    def send(self, **fields):
        self.feedback.clear()
        goal = Evolve.Goal(**fields)
        return self.result_of(
            self.client.send_goal_async(
                goal, feedback_callback=lambda m: self.feedback.append(m.feedback.stats)
            )
        )

    def run(self, **fields):
        return self.result_of(self.send(**fields).get_result_async())


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
    manager.wait(lambda: manager.feedback and manager.feedback[-1].phase > 2)
    asked = time.monotonic()
    manager.result_of(goal.cancel_goal_async())
    answer = manager.result_of(goal.get_result_async())
    assert answer.status == GoalStatus.STATUS_CANCELED
    assert time.monotonic() - asked < 10
    assert 0 < answer.result.phases < 150
    assert not answer.result.success
    assert f'resuming {cut}' in answer.result.message
    assert manager.run(out=str(cut), resume=True).result.success
    assert manager.run(out=str(whole), configuration=wanted).result.success
    assert read_files(cut) == read_files(whole)


def test_one_run_at_a_time(manager, tmp_path):
    goal = manager.send(out=str(tmp_path / 'a'), configuration=configuration(phases=10_000))
    answer = manager.run(out=str(tmp_path / 'b'), configuration=configuration(phases=1))
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert 'a run is in progress' in answer.result.message
    assert not (tmp_path / 'b').exists()
    manager.result_of(goal.cancel_goal_async())
    assert manager.result_of(goal.get_result_async()).status == GoalStatus.STATUS_CANCELED


@pytest.mark.parametrize(
    ('fields', 'sentence'),
    [
        ({'configuration': '{populaton: 3}'}, 'unknown configuration key populaton'),
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
        (['-p', 'evaluators:=-3'], 'evaluators out of range'),
        (['-p', 'patience:=soon'], 'patience'),
        (['-r', 'nothing'], "remap rule: '-r nothing'"),
    ],
)
def test_bad_arguments_are_refused(start, arguments, sentence):
    process = start(['coevo_manager', 'manager', '--ros-args', *arguments])
    assert process.wait(30) == 2
    assert sentence in process.stderr_text
    assert 'Traceback' not in process.stderr_text

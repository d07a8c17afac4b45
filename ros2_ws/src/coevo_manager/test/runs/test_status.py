"""status.json: where a run stands and how busy its evaluators are."""

import dataclasses
import json

import pytest

from coevo_manager.core.evolution import PhaseStats
from coevo_manager.evaluators.load import Load
from coevo_manager.runs.status import FILE_NAME, Pace, StatusFile

START = PhaseStats(0, 0, '', 0.25, 0.75, 0, 64, 10_000, 0.0)
LATER = PhaseStats(4, 40, 'prey', 0.5, 0.5, 3, 640, 40_000, 0.25)
END = dataclasses.replace(LATER, progress=1.0)


def test_the_pace_is_that_of_the_ticks():
    pace = Pace()
    assert pace.status(START, 100.0).ticks_per_second == 0
    status = pace.status(LATER, 110.0)
    assert status.ticks_per_second == pytest.approx(3000)
    assert status.seconds_left == pytest.approx(30)


def test_the_file_is_written_once_a_second_and_at_the_end(tmp_path):
    pace = Pace()
    file = StatusFile(tmp_path, lambda: {'evaluators': []})
    for stats in (START, LATER):
        file.write(pace.status(stats, 100.0))
    content = json.loads((tmp_path / FILE_NAME).read_text())
    assert (content['phase'], content['seconds_left'], content['evaluators']) == (0, None, [])
    file.write(pace.status(END, 102.0))
    assert json.loads((tmp_path / FILE_NAME).read_text())['progress'] == 1
    assert [path.name for path in tmp_path.iterdir()] == [FILE_NAME]


def test_a_folder_that_is_gone_stops_no_run(tmp_path):
    StatusFile(tmp_path / 'gone').write(Pace().status(START, 0.0))


def test_an_evaluator_is_busy_while_it_is_asked():
    load = Load(10.0)
    load.busy(12.0, True)
    load.busy(13.0, True)
    load.busy(15.0, False)
    load.episodes += 50
    assert load.since_last(20.0) == pytest.approx((0.3, 5.0))
    load.busy(21.0, True)
    assert load.since_last(25.0) == pytest.approx((0.8, 0.0))
    assert load.since_last(27.0) == pytest.approx((1.0, 0.0))

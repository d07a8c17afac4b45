"""What evolve shows: two lines that fit, lines in a pipe, nothing when quiet."""

import io
import math

import pytest
from rich.console import Console

from coevo_manager.core.evolution import GenerationStats, load_configuration
from coevo_manager.runs.display import PlainDisplay, TerminalDisplay, make_display
from coevo_manager.runs.status import Status

CONFIGURATION = load_configuration({}, 'paper')
STATS = GenerationStats(
    149_950, 1500, 'predator', 0.4125, 0.1, 0.9, 7, 16_206_000, 9_999_999_999, 0.25, 0.75, 0.9996
)
STATUS = Status(STATS, 123_400_000.0, 36_000.0)


def drawn(width, *statuses):
    """Lines that are on the screen, as a terminal of that width gets them."""
    console = Console(file=io.StringIO(), force_terminal=True, width=width, color_system=None)
    display = TerminalDisplay(CONFIGURATION, console)
    display.wait('the evaluators compile the simulation, which the first start has to')
    for status in statuses:
        display.status(status)
    with console.capture() as captured:
        console.print(display._render())
    return captured.get().splitlines()


@pytest.mark.parametrize('width', [200, 80, 60, 40, 24])
def test_a_run_has_two_lines_however_narrow_the_terminal(width):
    lines = drawn(width, STATUS)
    assert len(lines) == 2
    assert all(len(line.rstrip()) <= width for line in lines)
    assert lines[0].startswith('100%')
    assert lines[1].startswith('phase 1500/1500')
    assert ('━' in lines[0]) == (width >= 40)


def test_80_columns_show_all_that_matters():
    first, second = drawn(80, STATUS)
    assert first.rstrip().endswith('0:00:00, 10:00:00 left')
    assert 'generation 149950, predator evolving 0.412' in second


def test_a_run_without_end_has_no_clock_that_overflows():
    first, _ = drawn(80, Status(STATS, 1e6, 1e19))
    assert first.rstrip().endswith('more than a century left')


@pytest.mark.parametrize('width', [80, 30])
def test_waiting_has_one_line_with_a_clock(width):
    (line,) = drawn(width)
    assert line.startswith('0:00:00 the evaluators')
    assert len(line.rstrip()) <= width


def test_a_pipe_gets_plain_lines():
    file = io.StringIO()
    display = make_display(CONFIGURATION, console=Console(file=file))
    assert isinstance(display, PlainDisplay)
    with display:
        display.wait('starting the evaluators')
        display.status(STATUS)
        display.status(STATUS)  # too soon after the last
        display.event('done')
    first, second, last = file.getvalue().splitlines()
    assert (first, last) == ('starting the evaluators', 'done')
    assert second == (
        'phase 1500/1500, generation 149950, predator evolving 0.412, all 0.250 : 0.750, '
        '123.4 M ticks/s, 10:00:00 left'
    )


def test_what_is_not_known_is_not_shown():
    (_, second) = drawn(80, Status(STATS, 0.0, math.nan))
    assert 'ticks/s' not in second


def test_quiet_shows_nothing(capsys):
    with make_display(CONFIGURATION, quiet=True) as display:
        display.wait('starting the evaluators')
        display.status(STATUS)
        display.event('done')
        display.report('# Report')
    assert capsys.readouterr() == ('', '')

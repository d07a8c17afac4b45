"""Paths on command lines."""

import argparse

import pytest

from coevo_manager.analysis.command import make_parser as analyze
from coevo_manager.analysis.transfer.command import make_parser as transfer
from coevo_manager.command_line import new_path
from coevo_manager.dashboard.command import make_parser as dashboard
from coevo_manager.runs.campaign import make_parser as campaign
from coevo_manager.runs.evolve import main as evolve
from neuro_controller.core.champions import select_champion

LONG = 'x' * 300
WRONG = {'': 'the path is empty', LONG: "'xxxxxxxx.*has 300 characters"}


@pytest.mark.parametrize('text', WRONG)
def test_a_path_that_cannot_be_is_one_sentence(text, capsys):
    with pytest.raises(argparse.ArgumentTypeError, match=WRONG[text]):
        new_path(text)
    for option in ('--out', '--resume', '--config'):
        with pytest.raises(SystemExit) as end:
            evolve([option, text])
        assert end.value.code == 2
        assert capsys.readouterr().err.startswith(f'evolve: argument {option}: ')
    for make_parser in (analyze, transfer, dashboard, campaign):
        with pytest.raises(SystemExit) as end:
            make_parser().parse_args([text])
        assert end.value.code == 2
        said = capsys.readouterr().err
        assert said.count('\n') == 1 and ': argument ' in said


def test_a_genome_whose_name_is_too_long_is_a_value_error():
    with pytest.raises(ValueError, match='x cannot be read: File name too long'):
        select_champion(LONG, 'prey')

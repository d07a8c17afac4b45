"""Which runs are replications of what, and how conditions and arenas are named."""

import pytest

from coevo_manager.analysis.conditions import assign, slug
from coevo_manager.core.evolution import load_configuration


def named(*runs):
    """Name and arena of each run, given as values or as (values, name in a campaign)."""
    runs = [run if isinstance(run, tuple) else (run, '') for run in runs]
    configurations = {k: load_configuration(values) for k, (values, _) in enumerate(runs)}
    found = assign(configurations, {k: name for k, (_, name) in enumerate(runs)})
    return [(condition.name, condition.arena) for condition in found.values()]


def test_seed_and_budget_make_no_condition():
    found = named({'seed': 1}, {'seed': 2, 'phases': 7}, {'seed': 3, 'episodes': 10**9})
    assert found == [('Standard', 'open arena')] * 3


def test_algorithms_and_optimizers():
    found = named(
        {'algorithm': 'hall_of_fame'}, {'optimizer': 'cma_es'}, {'environment': 'obstacle'}
    )
    assert found == [
        ('Hall of fame', 'open arena'),
        ('Standard, CMA-ES', 'open arena'),
        ('Standard', 'arena with obstacle'),
    ]


def test_any_field_may_tell_conditions_apart():
    found = named({}, {'population': 40}, {'population': 40, 'selected': 20})
    assert [name for name, _ in found] == [
        'Standard, population 80, selected 10',
        'Standard, population 40, selected 5',
        'Standard, population 40, selected 20',
    ]
    assert named({'mutation_rate': 0.02}, {'mutation_rate': 0.1, 'algorithm': 'vanilla'}) == [
        ('Standard', 'open arena'),
        ('Vanilla', 'open arena'),
    ]


def test_the_names_of_a_campaign_are_its_conditions():
    found = named(({}, 'standard'), ({'selected': 20}, 'many_agents'))
    assert found == [('Standard', 'open arena'), ('Many agents', 'open arena')]
    twice = named(({}, 'mine'), ({'population': 40}, 'mine'))
    assert twice[0][0] == 'Mine, population 80, selected 10'


def test_worlds_are_arenas_of_their_own():
    found = named({'world': 'faithful'}, {'world': 'varied'}, {'world': 'varied'})
    assert [arena for _, arena in found] == [
        'open arena, faithful',
        'open arena, varied',
        'open arena, varied',
    ]
    found = named({'world': 'varied'}, {'world': 'varied', 'wall_friction': 0.25})
    assert [arena for _, arena in found] == [
        'open arena, varied',
        'open arena, varied, wall friction 0.25',
    ]


def test_the_study_of_readings_names_what_was_changed_in_which_world():
    base = {'world': 'faithful'}
    runs = [base, base | {'motor_map': 'printed'}, base | {'wall_contact': 'slide'}]
    found = named(*runs, {'world': 'varied'})
    assert [arena for _, arena in found] == [
        'open arena, faithful',
        'open arena, faithful, motor map printed',
        'open arena, faithful, wall contact slide',
        'open arena, varied',
    ]


@pytest.mark.parametrize(
    ('text', 'expected'),
    [('Standard, n 2', 'standard_n_2'), ('open arena, signed', 'open_arena_signed')],
)
def test_names_of_files(text, expected):
    assert slug(text) == expected

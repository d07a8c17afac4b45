"""The environments pass the field's own tests, and play the kernel's episodes bit for bit."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test, render_test
from pettingzoo.utils import parallel_to_aec

import red_queen as rq
from coevo_manager.core.episodes.numbering import episode_numbers
from red_queen.environments import ChaseEnv, ChaseParallelEnv, ChaseVectorEnv, GenomePolicy

ROBUST = rq.make_environment({**rq.WORLDS['robust'], 'environment': 'obstacle'})
IMPERFECT = rq.Environment(
    perturbations=rq.Perturbations(latency_ticks=2, command_loss=0.1, battery=0.9, seed=7)
)


@pytest.fixture(scope='module')
def pair():
    return [rq.select_champion('shipped/open', species).genome for species in rq.SPECIES]


def play(env, policies, **options):
    """Play an episode; return the ticks, each agent's return and how it ended."""
    observations, _ = env.reset(options=options)
    returns = dict.fromkeys(env.agents, 0.0)
    ticks = 0
    while env.agents:
        actions = {agent: policies[agent](observations[agent]) for agent in env.agents}
        observations, rewards, terminations, truncations, _ = env.step(actions)
        ticks += 1
        for agent, reward in rewards.items():
            returns[agent] += reward
    return ticks, returns, terminations['prey'], truncations['prey']


@pytest.mark.filterwarnings('ignore::UserWarning')
def test_pettingzoo_finds_nothing_wrong():
    parallel_api_test(ChaseParallelEnv(ROBUST), num_cycles=1500)
    parallel_seed_test(lambda: ChaseParallelEnv(ROBUST), num_cycles=50)
    render_test(lambda render_mode: parallel_to_aec(ChaseParallelEnv(render_mode=render_mode)))


@pytest.mark.parametrize('species', rq.SPECIES)
def test_gymnasium_finds_nothing_wrong(species):
    env = gymnasium.make('RedQueen/Chase-v0', species=species, render_mode='rgb_array').unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        warnings.filterwarnings('ignore', 'FigureCanvasAgg is non-interactive')
        check_env(env)


@pytest.mark.parametrize('world', [*rq.WORLDS, 'imperfect', 'robust with obstacle'])
def test_evolved_controllers_play_the_kernels_episode_bit_for_bit(pair, world):
    environment = {'imperfect': IMPERFECT, 'robust with obstacle': ROBUST}.get(world)
    environment = environment or rq.make_environment(rq.WORLDS[world])
    policies = dict(zip(rq.SPECIES, map(GenomePolicy, pair), strict=True))
    seen = {agent: [] for agent in rq.SPECIES}

    def watched(agent):
        return lambda observation: (seen[agent].append(observation), policies[agent](observation))[
            1
        ]

    numbers = episode_numbers(pair[::-1])
    env = ChaseParallelEnv(environment)
    ticks, returns, captured, over = play(
        env, {agent: watched(agent) for agent in rq.SPECIES}, episode_numbers=numbers
    )
    trace = rq.trace_pair(*pair, environment)
    assert (ticks, captured, over) == (trace.ticks, trace.captured, not trace.captured)
    (kernel_ticks,) = rq.evaluate_pairs(pair[:1], pair[1:], [0], [0], environment)
    assert ticks == kernel_ticks
    for robot, agent in enumerate(rq.SPECIES):
        assert np.array_equal(np.array(seen[agent]), trace.inputs[:, robot])
        assert returns[agent] == pytest.approx(rq.fitness(ticks, agent), abs=1e-12)


@pytest.mark.parametrize('species', rq.SPECIES)
@pytest.mark.parametrize('environment', [ROBUST, IMPERFECT], ids=['robust', 'imperfect'])
def test_a_frozen_opponent_is_the_kernels(pair, species, environment):
    own = rq.SPECIES.index(species)
    env = ChaseEnv(species, pair[1 - own], environment)
    policy = GenomePolicy(pair[own])
    observation, _ = env.reset(options={'episode_numbers': episode_numbers(pair[::-1])})
    ticks, ended = 0, False
    while not ended:
        observation, _, terminated, truncated, _ = env.step(policy(observation))
        ticks, ended = ticks + 1, terminated or truncated
    assert ticks == rq.evaluate_pairs(pair[:1], pair[1:], [0], [0], environment)[0]


def test_many_at_once_are_single_ones(pair):
    """Each pair of lanes plays what a `ChaseEnv` plays that begins with the same numbers."""
    environment = rq.make_environment({**rq.WORLDS['robust'], 'episode_ticks': 60})
    envs = ChaseVectorEnv(11, 'prey', pair[0], environment)
    observations, _ = envs.reset(seed=3)
    actions = np.random.default_rng(1).random((130, 11, 2), np.float32)
    rng = np.random.Generator(np.random.PCG64(3))
    numbers = rng.integers(2**64, size=(11, 2), dtype=np.uint64)
    single = ChaseEnv('prey', pair[0], environment)
    steps = [envs.step(action) for action in actions]
    for place in (0, 10):
        found, _ = single.reset(options={'episode_numbers': numbers[place]})
        assert np.array_equal(found, observations[place])
        for action, (after, rewards, captured, over, infos) in zip(actions, steps, strict=True):
            found, reward, terminated, truncated, _ = single.step(action[place])
            assert (reward, terminated, truncated) == (
                rewards[place],
                captured[place],
                over[place],
            )
            if terminated or truncated:
                assert infos['_final_obs'][place]
                assert np.array_equal(infos['final_obs'][place], found)
                assert after[place, 23] == 0  # the clock of the next episode
                break
            assert np.array_equal(after[place], found)
        else:
            pytest.fail('no episode ended')
    again = ChaseVectorEnv(11, 'prey', pair[0], environment)
    assert np.array_equal(again.reset(seed=3)[0], observations)
    assert all(np.array_equal(again.step(a)[0], s[0]) for a, s in zip(actions, steps, strict=True))


def test_seeds_decide_the_start():
    env = ChaseParallelEnv(rq.make_environment(rq.WORLDS['varied']))
    first, second, third = (env.reset(seed=seed)[0]['prey'] for seed in (1, 1, 2))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, third)
    assert not np.array_equal(third, env.reset()[0]['prey'])


@pytest.mark.parametrize(
    ('make', 'sentence'),
    [
        (lambda: ChaseEnv('wolf'), "species is 'wolf'"),
        (lambda: ChaseEnv(opponent='nowhere'), 'nowhere does not exist'),
        (lambda: ChaseEnv(opponent=np.zeros(3)), 'opponent has 3 genes'),
        (lambda: ChaseEnv(opponent=np.zeros((0, 442))), 'opponent holds no genome'),
        (lambda: ChaseEnv(render_mode='ansi'), "render_mode is 'ansi'"),
        (lambda: ChaseVectorEnv(0), 'num_envs is 0'),
        (lambda: ChaseParallelEnv(rq.Environment(physics='pymunk')), "physics is 'pymunk'"),
    ],
)
def test_bad_input_gets_a_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


@pytest.mark.parametrize('action', [[np.nan, 0.5], [0.5], 'left'])
def test_bad_actions_are_refused(action):
    env = ChaseEnv()
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r'action|could not convert'):
        env.step(action)

"""Mutation statistics, and every optimizer against a task with a known optimum."""

import itertools

import numpy as np
import pytest

from coevo_manager.core.evolution import load_configuration, optimizers
from coevo_manager.core.evolution.mutation import BLOCK, draw_mutations
from coevo_manager.core.evolution.optimizers.cma_es import reflect
from coevo_manager.core.evolution.optimizers.openai_es import centred_ranks
from neuro_controller.core.genome import GENE_RANGE, GENES, random_genomes

RATE = 0.02


def draw(kind, count, rate=RATE, seed=5):
    blocks = draw_mutations(kind, GENES, rate, GENE_RANGE, np.random.default_rng(seed))
    mutations = itertools.chain.from_iterable(map(each, blocks))
    return list(itertools.islice(mutations, count))


def each(mutations):
    """Genes and values of each mutation."""
    ends = np.cumsum(mutations.redrawn)[:-1]
    return list(
        zip(np.split(mutations.genes, ends), np.split(mutations.values, ends), strict=True)
    )


def test_bernoulli_mutations_are_independent_draws():
    drawn = draw('bernoulli', 20_000)
    counts = np.array([len(genes) for genes, _ in drawn])
    mean, variance = GENES * RATE, GENES * RATE * (1 - RATE)
    assert abs(counts.mean() - mean) < 5 * np.sqrt(variance / len(counts))
    assert abs(counts.var() / variance - 1) < 0.06
    hits = np.bincount(np.concatenate([genes for genes, _ in drawn]), minlength=GENES)
    expected = len(drawn) * RATE
    assert abs(hits - expected).max() < 5 * np.sqrt(expected)


def test_exact_mutations_redraw_that_many_different_genes():
    drawn = draw('exact', 5000)
    assert {len(genes) for genes, _ in drawn} == {round(GENES * RATE)} == {9}
    assert all(len(set(genes.tolist())) == 9 for genes, _ in drawn)
    hits = np.bincount(np.concatenate([genes for genes, _ in drawn]), minlength=GENES)
    expected = len(drawn) * 9 / GENES
    assert abs(hits - expected).max() < 5 * np.sqrt(expected)


@pytest.mark.parametrize('kind', ['bernoulli', 'exact'])
def test_redrawn_genes_are_uniform(kind):
    values = np.sort(np.concatenate([values for _, values in draw(kind, 10_000)]))
    assert values.dtype == np.float32
    assert abs(values).max() <= GENE_RANGE
    steps = np.arange(1, len(values) + 1) / len(values)
    distance = abs((values + GENE_RANGE) / (2 * GENE_RANGE) - steps).max()
    assert distance < 1.95 / np.sqrt(len(values))  # Kolmogorov-Smirnov, p = 0.001


@pytest.mark.parametrize('kind', ['bernoulli', 'exact'])
def test_rates_of_none_and_all(kind):
    assert all(len(genes) == 0 for genes, _ in draw(kind, BLOCK + 1, rate=0.0))
    assert all(len(genes) == GENES for genes, _ in draw(kind, BLOCK + 1, rate=1.0))


def closeness(genomes, target):
    """Fitness with a known optimum: 1 at the target, less by the mean squared distance."""
    return 1 - np.mean((genomes.astype(float) - target) ** 2, axis=1) / (2 * GENE_RANGE) ** 2


def start(name, seed=3, **values):
    configuration = load_configuration({'optimizer': name, **values})
    rng = np.random.default_rng(seed)
    target = random_genomes(1, rng)[0] * 0.8
    parent = random_genomes(1, rng)[0]
    fitness = closeness(parent[None], target)[0]
    return optimizers.load(name)(parent, fitness, configuration, rng), target, configuration


@pytest.mark.parametrize('name', optimizers.names())
def test_beats_random_search_on_a_known_optimum(name):
    evaluations = 4000
    optimizer, target, configuration = start(name)
    first = optimizer.best_fitness
    k = optimizers.load(name).candidates(configuration)
    for _ in range(evaluations // k):
        before = optimizer.best_fitness
        candidates = optimizer.ask()
        assert candidates.shape == (k, GENES)
        assert candidates.dtype == np.float32
        assert abs(candidates).max() <= GENE_RANGE
        fitness = closeness(candidates, target)
        improved = optimizer.tell(fitness)
        assert improved == (fitness.max() >= before)
        assert optimizer.best_fitness == max(before, fitness.max())
        assert optimizer.best_fitness == closeness(optimizer.best[None], target)[0]
    random = closeness(random_genomes(evaluations, np.random.default_rng(9)), target).max()
    assert random > first
    # The optimum is 1: at least a third of what random search leaves is gained on top of it.
    assert 1 - optimizer.best_fitness < (1 - random) * 2 / 3


@pytest.mark.parametrize('name', optimizers.names())
def test_equal_generators_give_equal_candidates(name):
    np.random.seed(0)  # noqa: NPY002 (an optimizer that drew from it would change)
    twice = [start(name) for _ in range(2)]
    for _ in range(5):
        (first, target, _), (second, _, _) = twice
        asked = first.ask(), second.ask()
        np.testing.assert_array_equal(*asked)
        for optimizer in (first, second):
            optimizer.tell(closeness(asked[0], target))
    other = start(name, seed=4)[0]
    assert (other.ask() != asked[0]).any()


@pytest.mark.parametrize('name', optimizers.names())
def test_an_equal_candidate_replaces_and_a_worse_one_does_not(name):
    optimizer, _, _ = start(name)
    fitness = optimizer.best_fitness
    candidates = optimizer.ask().copy()
    equal = np.full(len(candidates), fitness - 0.1)
    equal[-1] = fitness
    assert optimizer.tell(equal)
    np.testing.assert_array_equal(optimizer.best, candidates[-1])
    optimizer.ask()
    assert not optimizer.tell(np.full(len(candidates), np.nextafter(fitness, 0)))
    np.testing.assert_array_equal(optimizer.best, candidates[-1])


def test_a_parent_is_left_alone():
    parent = random_genomes(1, np.random.default_rng(1))[0]
    kept = parent.copy()
    for name in optimizers.names():
        optimizer = optimizers.load(name)(
            parent, 0.0, load_configuration({'optimizer': name}), np.random.default_rng(2)
        )
        optimizer.tell(np.ones(len(optimizer.ask())))
        np.testing.assert_array_equal(parent, kept)


def test_centred_ranks():
    # Salimans et al.'s fitness shaping; the two equal ones share ranks 1 and 2.
    np.testing.assert_allclose(
        centred_ranks(np.array([0.3, 0.9, 0.3, 0.1])), [0.0, 0.5, 0.0, -0.5], atol=1e-15
    )


def test_openai_es_follows_the_gradient():
    """Adam's first step has the length of its step size along each gene's gradient sign."""
    optimizer, target, _ = start('openai_es', openai_pairs=400, openai_step=0.05)
    centre = optimizer.ask()[0].astype(float)
    optimizer.tell(closeness(optimizer._genomes, target))
    step = optimizer.ask()[0] - centre
    inside = abs(centre) < GENE_RANGE - 0.1
    np.testing.assert_allclose(abs(step[inside]), 0.05, rtol=1e-3)
    assert np.corrcoef(step, target - centre)[0, 1] > 0.4


@pytest.mark.parametrize('spread', [0.0, 2.0])
def test_cma_es_is_as_good_as_the_library(spread):
    """Against pycma with a diagonal covariance, after the 100 generations of a phase."""
    import cma

    left = []
    for seed in range(3):
        optimizer, target, configuration = start('cma_es', seed)
        parent, rng = optimizer.best, np.random.default_rng(seed)
        weights = np.exp(rng.normal(0, spread, GENES))
        weights /= weights.sum()

        def error(genomes, target=target, weights=weights):
            return (genomes - target) ** 2 @ weights

        options = {'bounds': [-GENE_RANGE, GENE_RANGE], 'CMA_diagonal': True}
        options |= {'popsize': configuration.cma_candidates, 'seed': seed + 1, 'verbose': -9}
        library = cma.CMAEvolutionStrategy(parent, configuration.cma_sigma, options)
        best = np.inf
        for _ in range(100):
            errors = error(optimizer.ask())
            optimizer.tell(-errors)
            best = min(best, errors.min())
            asked = library.ask()
            library.tell(asked, error(np.array(asked)))
        left.append((best, library.best.f))
    ours, theirs = np.mean(left, axis=0)
    assert ours < 1.2 * theirs


def test_cma_es_takes_shorter_steps_where_they_change_more():
    optimizer, target, _ = start('cma_es')
    weights = np.where(np.arange(GENES) < 5, 1000, 1)
    for _ in range(300):
        optimizer.tell(-((optimizer.ask() - target) ** 2 @ weights))
    steps = optimizer._deviations
    assert steps[:5].mean() < 0.8 * steps[5:].mean()


def test_cma_es_goes_on_where_the_last_move_was_good():
    """The first two candidates lie ahead of and behind the mean; ahead is better: longer steps."""
    optimizer, _, _ = start('cma_es')
    sigmas = [optimizer._sigma]
    for better in (0, 0, 1, 1, 1):
        candidates = optimizer.ask()
        fitness = np.linspace(0.4, 0.5, len(candidates))
        fitness[:2] = 0.3
        fitness[better] = 0.6
        optimizer.tell(fitness)
        sigmas.append(optimizer._sigma)
    np.testing.assert_array_equal(optimizer._noise[0], -optimizer._noise[1])
    assert np.linalg.norm(optimizer._noise[0]) == pytest.approx(np.sqrt(GENES), rel=0.2)
    assert sigmas[0] == sigmas[1] < sigmas[2]
    assert sigmas[5] < sigmas[4]


def test_limits_of_genes_are_mirrors():
    genes = np.array([-5.0, 4.5, 5.5, -6.0, 14.0, 16.0, -25.0, 36.0])
    np.testing.assert_allclose(reflect(genes), [-5.0, 4.5, 4.5, -4.0, -4.0, -4.0, -5.0, -4.0])


def test_unknown_optimizer_is_named():
    with pytest.raises(
        ValueError,
        match="optimizer is 'annealing', expected one of cma_es, one_plus_one, openai_es",
    ):
        optimizers.load('annealing')


def test_mutations_are_those_that_asking_one_by_one_applies():
    ahead, one_by_one = start('one_plus_one')[0], start('one_plus_one')[0]
    parent = ahead.best.copy()
    for genes, values in each(ahead.mutations(5)):
        expected = parent.copy()
        expected[genes] = values
        (candidate,) = one_by_one.ask()
        np.testing.assert_array_equal(candidate, expected)
        assert not one_by_one.tell(np.array([-1.0]))
    # One that is accepted is applied to what the failures before left: the parent.
    assert [ahead.tell(np.array([fitness])) for fitness in (-1.0, -1.0, 2.0)] == [
        False,
        False,
        True,
    ]
    genes, values = each(start('one_plus_one')[0].mutations(3))[2]
    parent[genes] = values
    np.testing.assert_array_equal(ahead.best, parent)
    assert ahead.best_fitness == 2.0


@pytest.mark.parametrize('name', [n for n in optimizers.names() if n != 'one_plus_one'])
def test_only_lineages_have_mutations(name):
    assert start(name)[0].mutations(5) is None

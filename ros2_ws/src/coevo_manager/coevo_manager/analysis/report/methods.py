"""What the report says of its measures and tables."""

METHODS = (
    (
        'Fitness',
        'The fitness of a predator is 1 - t/T and that of a prey t/T, where t is the tick of '
        'capture and T the length of an episode (t = T without capture). Both sum to 1. Episodes '
        'are deterministic, so each pair plays one.',
    ),
    (
        'Master tournament',
        'All individuals of both populations at each generation compared meet all of every '
        'other. Matrices hold predator fitness, with a row for predators and a column for prey.',
    ),
    (
        'Historical progress (section 2.3, Table 1)',
        'Agents do better against opponents of an earlier generation than against those of '
        'their own. The table names the most recent such generation.',
    ),
    (
        'Global progress (section 2.3, Table 2)',
        'Agents do better against the opponents of the last generation than agents of an '
        'earlier generation do. The table names the most recent such earlier generation.',
    ),
    (
        'Duration and rate of progress',
        'The duration is the last generation whose entry in Table 1 or 2 exceeds every entry '
        'before it, which is how the paper reads its tables. The rate says how much better that '
        "generation's agents do than those of generation 0 against the opponents of all "
        'generations before, per 1000 generations.',
    ),
    (
        'Verdicts',
        'A verdict rests on one number a replication: the gain of the second half of the run. '
        'Historical is the gain against opponents of the first half rather than its own '
        'generation. Global is the gain over the agents of the first half, against the opponents '
        'of all generations, earlier and later. Held-out is the same against the best of other '
        "runs' last generation. Generation 0 is left out, since anything beats random genomes. A "
        'gain is called progress when the paired one-tailed t-test over replications, '
        'Holm-corrected over the verdicts of the condition, is below 0.05 and the tournament is '
        'more transitive than cyclic. Where it is more cyclic, such a gain is called cyclic: the '
        'halves may just be different phases of a cycle. A fall that is as significant is called '
        'retrogression. Where no replication gained or lost anything there is nothing to test, '
        'and the verdict is no change.',
    ),
    (
        'Statistics',
        "The replication is the unit. p paper is the paper's one-tailed Student's t-test, "
        "uncorrected. p paired is the one-tailed paired t-test, and p welch is Welch's. p sign "
        'flip is the exact permutation test over the signs of the replications; its smallest '
        'value is 1/2 to the number of replications. Columns with holm are corrected over the '
        "table. The bootstrap gives a 95 % percentile interval. Hedges' g is the difference in "
        'standard deviations, corrected for small samples. Generations and individuals of one '
        'run are never counted as independent.',
    ),
    (
        'Complexity c (section 4)',
        'c is the sum over the s ticks of an episode of |change of (l + r)/2| + |change of (r - '
        'l)/2| of the desired wheel speeds l and r, from rest, divided by 2 s. Its unit is rad/s '
        'per tick of 0.1 s.',
    ),
    (
        'Behaviour',
        'A sample of each generation, individuals of every rank, meets the best opponents of its '
        'own generation (contemporaries) and those of the last generation of its run (fixed), '
        'with sensors that are free of noise. Means are over the episodes that no capture ended. '
        'These are of equal length, while in short ones the start from rest weighs more. A '
        'robot drives forward or backward while the mean of its wheel speeds is at least 1 '
        'rad/s. Else it turns on the spot (half their difference is at least 1 rad/s) or pauses. '
        'Reversals are changes between forward and backward in 100 s; slow moments between them '
        'are not counted.',
    ),
    (
        'Rate of retrogression',
        'The rate is the fraction of (step between successive generations, generation of '
        'opponents) pairs in which performance falls. It is 0 in steady progress, and about 0.5 '
        'in change without direction. Share lost is the falls over all changes, in absolute '
        'value.',
    ),
    (
        'Cyclicity',
        'Generation i beats j by the predator fitness of i against j less that of j against i. '
        'The Hodge decomposition of this antisymmetric matrix gives each generation a rating '
        '(transitive part); the rest is cyclic. The share is of the sum of squares.',
    ),
    (
        'Game theory of the tournament',
        'The tournament of a run is a zero-sum game in which a generation of predators and one '
        'of prey are chosen. Nash averaging (Balduzzi et al. 2018) is its equilibrium of '
        'greatest entropy; the rating of a generation is its fitness against the other side of '
        'it, less the value. Alpha-rank (Omidshafiei et al. 2019) is the stationary distribution '
        'of mutants that take over finite populations. The exploitability of the meta-game is '
        'what the best other predators and prey of the tournament gain against a generation. The '
        'effective diversity (Balduzzi et al. 2019) is that of the game between generations; it '
        'is 0 where one beats all.',
    ),
    (
        'League',
        'Runs of different conditions play each other with both species of their last '
        "generation. A run wins if its predators do better against the other's prey than the "
        "other's against its own. OpenSkill's Plackett-Luce model rates the runs, match by "
        'match.',
    ),
    (
        'Exploitability',
        'A fresh (1+1) search (2 % of genes redrawn a mutation, from random genomes) looks for a '
        'best response to one frozen champion, the best of its population against its '
        'contemporaries. The fitness of the opponent found is a lower bound on what can be had '
        'against the champion. The mean while searching, and the candidates needed until one '
        'scores 0.5, tell how long the champion holds out.',
    ),
)

TABLES = {
    'table1': (
        'Historical progress (Table 1).',
        'The table has the most recent generation of earlier opponents against which the agents '
        'of a generation do significantly better than against their own; 0 means none after '
        'generation 0.',
    ),
    'table2': (
        'Global progress (Table 2).',
        'The table has the most recent earlier generation of agents that does significantly '
        'worse against the last opponents than the agents of a generation; 0 means none after '
        'generation 0.',
    ),
    'durations': (
        'Duration and rate of progress and complexification.',
        "Durations are in generations, by the paper's tests and by Holm-corrected paired tests.",
    ),
    'verdicts': (
        'Verdicts.',
        'The numbers behind the answers at the top. Tests are explained under Methods.',
    ),
    'cross_tests': (
        'Cross-experiment tests (Fig. 4).',
        'First is the fitness of the agents against the opponents of the other condition. Second '
        "is that against their own condition's, with (all) or without (held-out) their own run. "
        'Tests are explained under Methods.',
    ),
    'complexity_condition_tests': (
        'Complexity between conditions.',
        'The tests compare the last generation and are one-tailed. p permutation exchanges the '
        'labels of the runs.',
    ),
    'complexity_correlation': (
        'Correlation of complexity and performance (Fig. 7).',
        'Correlations are over generations, of the mean over replications, as in the paper, and '
        'within each replication (seed). Generations of a run are not independent, so p is too '
        'small.',
    ),
    'behaviour': (
        'What the robots do.',
        'These are means over episodes of equal length without sensor noise. Complexity is in '
        'rad/s per tick, reversals are in 100 s, and the others are shares of time.',
    ),
    'league': (
        'League of conditions.',
        'These are OpenSkill ratings over all pairs of runs of different conditions, the best '
        'first. At least is the rating less three deviations.',
    ),
    'effective_diversity': (
        'Effective diversity of the tournament.',
        'The table has a number for each run. It is explained under Methods.',
    ),
    'retrogression': (
        'Rate of retrogression.',
        'The table has a number for each run.',
    ),
}

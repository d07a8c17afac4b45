"""What a controller can be set to."""

MOTOR_MAPS = {'signed': (2.0, -1.0), 'printed': (1.0, 0.0)}
"""How the motor neuron rm becomes a drive, scale * rm + offset: with 2 rm - 1 in place of rm,
where a robot can back up (FARSA), or as equations 3 and 4 print it, where it cannot."""

INFRARED_RESPONSES = {'squared': 0.0, 'linear': 1.0}
"""How an infrared distance d becomes an activation, a max(a, least factor) with a = 1 - d/range:
a^2 (the authors' sampled tables), or a."""

GROUND_CODINGS = {'relative': (10.0, 1.0, 0.5), 'raw': (1.0, 0.0, 0.0)}
"""How a ground sensor's darkness g becomes a neuron, offset + gain (g - share * mean) kept in
0..1, as gain, share and offset: 0.5 + 10 (g - mean), which tells directions (the authors' later
code), or g. The fifth neuron is the mean of the readings in both."""

MIN_WHEEL_SPEED = 0.01
"""Lowest setting of the highest wheel speed, rad/s."""

MAX_WHEEL_SPEED = 30.0
"""Highest wheel speed, rad/s, that a controller can be set to; commands keep their grid of
2**-16 up to there."""

FIRST_RUNS = {
    'world': 'faithful',
    'wall_contact': 'slide',
    'infrared_response': 'linear',
    'ground_coding': 'raw',
}
"""Fields of the configuration in runs that do not say, from before there was a choice."""

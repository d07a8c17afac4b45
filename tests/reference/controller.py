"""The network and the motors (paper, appendix A2 and A3)."""

import numpy as np

GRID = 2.0**-16
WINDOW = 200


def split(genomes):
    """The 442 genes of each genome, (..., 442), by name: weights as (..., target, source)."""
    cuts = np.cumsum([12, 250, 100, 10, 50])
    bias, sensor_hidden, hidden_hidden, leak, sensor_output, hidden_output = np.split(
        np.asarray(genomes, float), cuts, axis=-1
    )
    lead = bias.shape[:-1]
    return {
        'hidden_bias': bias[..., :10],
        'output_bias': bias[..., 10:],
        'sensor_hidden': sensor_hidden.reshape(*lead, 10, 25),
        'hidden_hidden': hidden_hidden.reshape(*lead, 10, 10),
        'leak': np.abs(leak) / 5,
        'sensor_output': sensor_output.reshape(*lead, 2, 25),
        'hidden_output': hidden_output.reshape(*lead, 2, 10),
    }


def logistic(x):
    return 1 / (1 + np.exp(-x))


def inputs(readings, clock, fatigue, infrared_response, ground_coding):
    """The 25 sensory neurons, all in [0, 1], from the 37 readings."""
    activation = np.maximum(1 - readings[..., :24] / 0.1, 0)
    if infrared_response == 'squared':
        activation = activation**2
    groups = activation.reshape(*activation.shape[:-1], 8, 3).mean(axis=-1)
    camera, ground, contact = readings[..., 24:32], readings[..., 32:36], readings[..., 36:]
    mean = ground.mean(axis=-1, keepdims=True)
    if ground_coding == 'relative':
        ground = np.clip(0.5 + 10 * (ground - mean), 0, 1)
    return np.concatenate(
        [
            groups,
            camera,
            camera.mean(axis=-1, keepdims=True),
            ground,
            mean,
            contact,
            clock[..., None],
            fatigue[..., None],
        ],
        axis=-1,
    )


def decide(genes, sensors, hidden):
    """One step of the leaky recurrent network.

    Parameters
    ----------
    genes : dict
        What :func:`split` returns.
    sensors : array (..., 25)
    hidden : array (..., 10)
        Hidden neurons of the tick before.

    Returns
    -------
    hidden : array (..., 10)
    outputs : array (..., 2)
        Translation ``tm`` and rotation ``rm``.
    """
    net = (
        genes['hidden_bias']
        + (genes['sensor_hidden'] @ sensors[..., None])[..., 0]
        + (genes['hidden_hidden'] @ hidden[..., None])[..., 0]
    )
    hidden = genes['leak'] * hidden + (1 - genes['leak']) * logistic(net)
    outputs = logistic(
        genes['output_bias']
        + (genes['sensor_output'] @ sensors[..., None])[..., 0]
        + (genes['hidden_output'] @ hidden[..., None])[..., 0]
    )
    return hidden, outputs


def tiredness(spent):
    """Equation 1: ``tir`` from the spent energy ``rs`` of the last 200 ticks, (..., 200)."""
    return (spent.sum(axis=-1) / WINDOW) ** 2


def wheel_commands(outputs, tiredness, max_speed, motor_map):
    """Equations 2-5: wheel speeds (..., 2), left and right, rad/s, on a grid of 2**-16."""
    translation, rotation = outputs[..., 0], outputs[..., 1]
    speed = max_speed * (1 - tiredness)
    drive = speed * (rotation if motor_map == 'printed' else 2 * rotation - 1)
    slowed = drive * (-(2**3) * (translation - 0.5) ** 2 + 1)
    left = np.where(translation < 0.5, slowed, drive)
    right = np.where(translation > 0.5, slowed, drive)
    return on_grid(np.stack([left, right], axis=-1))


def spent_energy(wheels, max_speed):
    """``rs`` of a tick: mean absolute wheel speed over the maximum, on a grid of 2**-16."""
    return on_grid(np.abs(wheels).mean(axis=-1) / max_speed)


def on_grid(value):
    return np.round(value / GRID) * GRID

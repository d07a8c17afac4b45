"""Where genomes come from: the run that evolved them, and what robots it gave them."""

from dataclasses import dataclass

from neuro_controller.core.genome import HIDDEN, Layout
from neuro_controller.core.reading import parse_json, read_arrays, read_text, reading
from neuro_controller.core.settings import FIRST_RUNS, settings_column

PREDATOR_SPEEDS = {'open': 8.5, 'obstacle': 10.0}
"""Highest wheel speed of predators, rad/s, in runs that left it to the paper (A1, section 5)."""

_SETTINGS = ('motor_map', 'episode_ticks', 'infrared_response', 'ground_coding')


@dataclass(frozen=True)
class Origin:
    """The run that genomes come from.

    Attributes
    ----------
    run : str
        Its name.
    generation : int
        When they lived.
    commit : str
        Version of the program that evolved them; 'unknown' where none was recorded.
    configuration : dict
        Every field of the run's configuration, as in its run.json, completed by `FIRST_RUNS`.
    """

    run: str
    generation: int
    commit: str
    configuration: dict

    @classmethod
    def parse(cls, record, run, generation):
        """Return the origin that a run's record tells of.

        Parameters
        ----------
        record : str
            Text of a run.json; its `run`, if it has one, is the run's name.
        run : str
            The run's name otherwise.
        generation : int

        Raises
        ------
        ValueError
            The text is no record of a run.
        """
        try:
            content = parse_json(record)
            name = content.get('run', run)
            commit = content.get('versions', {}).get('commit', 'unknown')
            configuration = {**FIRST_RUNS, **content['configuration']}
            origin = cls(str(name), generation, str(commit), configuration)
            origin.layout  # noqa: B018  refuses what makes no sense
            for species in ('predator', 'prey'):
                settings_column(**origin.settings(species))
        except KeyError as error:
            raise ValueError(f'the record of its run lacks {error}') from None
        except (ValueError, TypeError, AttributeError, RecursionError) as error:
            raise ValueError(f'the record of its run makes no sense: {error}') from None
        return origin

    @property
    def layout(self):
        """What the genomes are genomes of, a `Layout`."""
        return Layout(self.configuration.get('hidden', HIDDEN))

    def settings(self, species):
        """Return the parameters of `Controller`, by name, that a species evolved with."""
        speed = self.configuration[f'{species}_speed']
        if speed is None:
            speed = PREDATOR_SPEEDS[self.configuration['environment']]
        settings = {name: self.configuration[name] for name in _SETTINGS}
        return {'max_wheel_speed': float(speed), **settings}

    def __str__(self):
        return f'generation {self.generation} of run {self.run}, commit {self.commit}'


def read_origin(path):
    """Return where the genomes of a snapshot come from.

    Parameters
    ----------
    path : pathlib.Path
        A npz file with `generation` and `run`, the text of its run's run.json. Snapshots of the
        first runs lack that: then their run folder has it.

    Raises
    ------
    ReadingError
        The file is damaged, or nothing tells how the genomes evolved.
    """
    in_folder = path.parent.name == 'snapshots'
    run = path.resolve().parent.parent.name if in_folder else path.stem
    arrays = read_arrays(path, ('generation',))
    with reading(path):
        record = str(arrays['run']) if 'run' in arrays else _record_beside(path)
        return Origin.parse(record, run, int(arrays['generation']))


def _record_beside(path):
    record = path.resolve().parent.parent / 'run.json'
    if not record.is_file():
        raise ValueError(f'it holds no run, and {record} does not exist')
    return read_text(record)

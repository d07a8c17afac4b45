"""The two species: their names, and how they are told apart in text and pictures."""

from neuro_controller.core.snapshot import SPECIES

__all__ = ['COLOURS', 'OTHER', 'PLURAL', 'SPECIES']

OTHER = {'predator': 'prey', 'prey': 'predator'}
PLURAL = {'predator': 'predators', 'prey': 'prey'}
COLOURS = {'predator': '#b3341f', 'prey': '#3b93cf'}
"""Red is dark and blue is light: the colour-blind tell them apart, and so does grey print."""

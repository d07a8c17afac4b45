"""Competitive co-evolution of predators and prey."""

__version__ = '0.1.0'

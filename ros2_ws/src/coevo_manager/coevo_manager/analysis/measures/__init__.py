"""Measures and statistics on arrays; they need no run folder and no simulation."""

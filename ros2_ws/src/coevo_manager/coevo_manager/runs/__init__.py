"""Runs from the command line, as an action, and many at a time."""

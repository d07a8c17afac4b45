"""Lineages that share an archive (Archive* of Nolfi and Pagliuca 2025)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.algorithms.archive import ArchiveOfBest
from marxbot_sim.core.fields import Option


class ArchiveStar(ArchiveOfBest):
    """Several lineages a species, which do not know of each other, fill one archive.

    Each opponent is of another lineage in turn, and of any time.
    """

    defaults: ClassVar[Mapping[str, Any]] = {**ArchiveOfBest.defaults, 'snapshot_generations': 20}
    parameters: ClassVar = (
        Option('archive_lineages', int, 5, 'lineages of a species', 'lineages', 1, 1024),
    )

    @classmethod
    def lineages(cls, configuration: Configuration) -> int:
        """Return the number of lineages."""
        return configuration.archive_lineages

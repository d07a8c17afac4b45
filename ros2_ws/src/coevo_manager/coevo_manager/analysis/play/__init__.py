"""The episodes that the analysis plays, stored by content."""

"""Analysis of runs: measures, statistics, figures and the report (docs/analysis.md)."""

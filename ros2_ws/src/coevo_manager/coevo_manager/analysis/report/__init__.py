"""Tables, and report.html with its episode player."""

"""A page that shows runs and robots while they run: readers, plays and a small web server."""

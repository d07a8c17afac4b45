"""Episodes over topics: played, recorded in bags, replayed and drawn."""

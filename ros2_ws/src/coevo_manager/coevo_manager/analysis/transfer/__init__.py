"""Champions under other physics and with imperfect robots."""

"""What a moving bar shows, in words, tables and figures."""

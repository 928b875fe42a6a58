"""What is wrong with a recording: events, lines, resolution, and what a filter would leave."""

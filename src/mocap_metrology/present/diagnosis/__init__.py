"""What is wrong with a recording: the page that proves it."""

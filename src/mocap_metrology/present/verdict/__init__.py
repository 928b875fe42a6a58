"""The verdict on a recording in words and in a figure."""

"""What the rules of the workflow and the command for one file both do: a file a step, tables in,
tables out."""

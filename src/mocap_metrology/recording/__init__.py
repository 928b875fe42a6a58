"""The steps of a recording, tables in, tables out: `steps` has each once."""

"""Pages of HTML: summary, tables, provenance."""

"""A facility over months: chart, table, words."""

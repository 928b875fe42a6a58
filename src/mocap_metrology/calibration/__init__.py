"""The steps of a calibration, tables in, tables out."""

"""Run time against error."""

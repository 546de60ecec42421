"""Comparison with other renderers: see validation/run.sh and validation/README.md."""

"""Modelling helpers behind scenes/make_assets.py."""

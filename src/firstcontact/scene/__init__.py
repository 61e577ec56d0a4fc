"""Scenes in TOML: bodies, motions and questions."""

"""Random and degenerate scenes for `benchmarks/soak.py`, one file per family, each with oracles of its own.

Nothing here asks the library for a truth: oracles are closed forms, exact rational brute force, or sampling with static
tests written here.  The library is reached through its public face only, by the text of a scene.
"""

"""Exact arithmetic: python-flint only, no NumPy, no Numba, nothing of the layers above."""

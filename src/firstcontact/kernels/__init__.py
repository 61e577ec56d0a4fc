"""Float kernels: Numba only, nothing exact, nothing of the layers above."""

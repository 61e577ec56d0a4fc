"""Polynomials of several variables, matrices of them, and Bernstein form."""

"""Algebraic numbers: real roots, number fields and their towers, signs under conditions."""

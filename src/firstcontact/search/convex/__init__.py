"""Convex pieces: separation, advancement, close looks, and how two solids lie at one instant."""

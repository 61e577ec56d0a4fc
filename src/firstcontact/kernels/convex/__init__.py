"""Convex pieces: support points, separation, advancement and the moment of touch."""

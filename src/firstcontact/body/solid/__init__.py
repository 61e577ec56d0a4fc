"""Solids of planes and quadrics: carriers, their Boolean tree, and the faces, edges and vertices derived from it."""

"""Triangles for solids of planes and quadrics, for the viewer and for whoever wants a mesh."""

"""Polyhedra: vertices, edges and facets with exact coordinates."""

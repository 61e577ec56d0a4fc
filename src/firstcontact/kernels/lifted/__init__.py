"""Queries in the lifted space of lines and edges (Schömer & Thiel 1995)."""

"""Arcs of intersection curves: cells, nets, tracing and trimming."""

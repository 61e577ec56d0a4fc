"""Ruled surfaces: strips between two directrices, rational or NURBS, whole or trimmed."""

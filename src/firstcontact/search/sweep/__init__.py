"""The engine that sweeps facets as sheets about an axis, or along a direction."""

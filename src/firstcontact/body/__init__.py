"""Bodies: shapes at rest and in motion."""

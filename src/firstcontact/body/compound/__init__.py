"""Bodies of several pieces, as parts and assemblies are."""

"""Events of two ruled surfaces: pieces of them in motion."""

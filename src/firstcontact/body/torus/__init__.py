"""The torus: a body with one face, of degree four."""

"""Candidate search: the time-swept tree and the walks over two of them."""

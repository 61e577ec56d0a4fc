"""Boxes swept in time, and the walks over two trees of them."""

"""Instants and windows of time with exact ends."""

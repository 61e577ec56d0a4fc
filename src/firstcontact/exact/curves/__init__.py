"""Topology of plane curves and of the common curve of two quadrics; families of lines."""

"""What two models share where they touch: points, segments, arcs and patches, and the features that hold them."""

"""Events of features of solids: boxes, forms in motion and their search."""

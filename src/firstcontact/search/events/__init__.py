"""The first event of features of solids and ruled surfaces, with a proof."""

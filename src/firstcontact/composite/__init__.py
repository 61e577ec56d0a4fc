"""Composite quadric models in contact, by the algebra of Choi et al. 2014."""

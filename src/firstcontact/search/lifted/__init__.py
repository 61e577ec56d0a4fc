"""The sub-quadratic engine: elements and motions lifted, halving and cutting of space (Schömer & Thiel 1995)."""

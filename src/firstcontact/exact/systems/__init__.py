"""Square systems of polynomials: isolation of their roots, Krawczyk's test."""

"""The text of a STEP file: what it tells before anything is made of it, and what OpenCASCADE reads otherwise."""

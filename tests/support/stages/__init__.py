"""One part of a robot or of the world on a stage, and what the others say to it."""

"""The parts of a fleet as processes: their command lines, their lives, and what they share."""

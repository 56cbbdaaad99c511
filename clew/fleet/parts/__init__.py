"""The parts of a fleet as processes: their command lines, their life cycle, and what they share."""

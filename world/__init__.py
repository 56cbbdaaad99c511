"""The ground that a fleet moves on: bodies, sensors, judgement and the record."""

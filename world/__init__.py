"""The simulated world of a fleet: bodies, sensors, judgement and the timeline."""

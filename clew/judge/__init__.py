"""A second judge, of poses and scene alone. It imports nothing of ours, so it shares no mistake of ours."""

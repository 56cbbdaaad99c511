"""Reads maps as ROS keeps them, and makes scenes of them."""

"""Reads maps in the format of `map_server` of ROS, and makes scenes of them."""

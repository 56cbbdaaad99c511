"""The live table: what a run's timeline says of each robot, on a terminal."""

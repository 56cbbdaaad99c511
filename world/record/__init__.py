"""What is written down of a run, and how a world goes on from it."""

"""`clew bench hop`: how long news takes from the leader's put to the reaction of the last robot."""

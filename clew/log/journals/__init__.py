"""What the journals of a run's robots show: messages and their fates, the cores' states, and causes."""

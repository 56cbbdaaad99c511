"""Many rehearsals: episodes, executors, shrinking, live chaos."""

"""Many rehearsals: episodes, shrinking, mutants, live chaos."""

"""Many rehearsals: episodes, coverage, shrinking, mutants, live chaos."""

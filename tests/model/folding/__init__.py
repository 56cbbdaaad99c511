"""A model of its own: how a strand lies, and that none folds back."""

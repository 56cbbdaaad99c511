"""What happened in a run, derived from its entries for whoever shows it."""

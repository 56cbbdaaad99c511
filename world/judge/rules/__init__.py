"""The rules by which the judge finds violations, entry by entry: S1 to S3, F1 to F6, and P1 to P6."""

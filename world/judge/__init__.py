"""Whether a run kept its promises: S1 to S3, P1 to P6, books, recovery, verdict."""

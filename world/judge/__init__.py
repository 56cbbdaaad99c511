"""The judgement of a run: S1 to S3, F1 to F6, P1 to P6, message accounts, recovery, verdict."""

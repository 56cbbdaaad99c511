"""The judgement of a run: its invariants (docs/verdict.md), message accounts, recovery, verdict."""

"""The judgement of a run: its invariants (docs/verdict.md), books, recovery, verdict."""

"""What `import clew` gives: runs as objects, fleets that go on, faults as functions. `docs/python.md`."""

"""Settings of hypothesis for all tests."""

from hypothesis import settings

# No claim here is about time, and on a loaded machine any single example may take longer than 200 ms.
settings.register_profile("clew", deadline=None)
settings.load_profile("clew")

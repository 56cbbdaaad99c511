"""Tests of `protocol/wire/`."""

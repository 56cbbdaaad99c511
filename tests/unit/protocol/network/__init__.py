"""Tests of `protocol/network/`."""

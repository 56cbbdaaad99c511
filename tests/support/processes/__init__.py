"""Fleets, routers, proxies and terminals for tests."""

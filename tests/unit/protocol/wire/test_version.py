"""Two processes of one schema version understand each other: what changes on the wire raises the version."""

from hashlib import blake2b
from typing import Any

import msgspec

from protocol.wire.codec import SCHEMA_VERSION
from protocol.wire.messages import Message

WIRE = (4, "a32f42ff2dc7550c")
"""The schema version, and the digest of all that its messages are made of."""


def without_texts(schema: Any) -> Any:  # noqa: ANN401 - any part of a JSON Schema
    if isinstance(schema, dict):
        kept = {key: part for key, part in schema.items() if key != "description" or isinstance(part, dict)}
        return {key: without_texts(part) for key, part in kept.items()}
    return [without_texts(part) for part in schema] if isinstance(schema, list | tuple) else schema


def test_messages_change_only_with_the_schema_version() -> None:
    """If it fails, raise `SCHEMA_VERSION` and write both here, so that two versions refuse each other."""
    schema = without_texts(msgspec.json.schema(Message))
    digest = blake2b(msgspec.json.encode(schema, order="deterministic"), digest_size=8).hexdigest()
    assert (SCHEMA_VERSION, digest) == WIRE

"""The wire protocol: messages, their encoding, links and movement authority."""

"""Parts of the docs that are made from our types."""

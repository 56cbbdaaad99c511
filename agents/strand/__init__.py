"""One robot in the strand: it leads or follows, is granted ground and grants it."""

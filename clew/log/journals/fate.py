"""What can become of a message. It imports nothing, for the completion of a command line."""

from enum import StrEnum


class Fate(StrEnum):
    """What became of a message."""

    DELIVERED = "delivered"
    DELAYED = "delayed"  # a fault has held it back
    DUPLICATED = "duplicated"  # a fault has delivered it more than once
    DROPPED = "dropped"  # a fault has removed it
    DAMAGED = "damaged"  # a fault has changed its bits, so it was refused
    REFUSED = "refused"  # it broke the protocol

"""What robots record, held against true poses: who may record it, arrivals, promised clearances."""

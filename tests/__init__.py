"""Units by package and room, rehearsals, real processes, the browser, the house; helpers in `support`."""

"""The top floor: preparing runs, reading their timelines, the command line."""

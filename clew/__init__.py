"""The public package: preparing runs, reading their timelines, the command line."""

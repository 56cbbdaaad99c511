"""The verbs of the command line, one file each: options, exit code, table or JSON."""

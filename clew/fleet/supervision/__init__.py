"""How the processes of a fleet are supervised: events, commands, rules, facts."""

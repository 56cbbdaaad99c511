"""What plays the episodes of a campaign: processes of this machine, or the workers of a cluster."""

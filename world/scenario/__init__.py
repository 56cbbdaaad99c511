"""From files to frozen values: scenarios, scenes, deployments, and what they may not be."""

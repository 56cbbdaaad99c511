"""From scans to steps: obstacles, gaps, certificates, the map and the cost-to-go."""

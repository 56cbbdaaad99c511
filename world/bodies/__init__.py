"""The bodies of robots: motion and sensors."""

"""What one scan and its memory say of the ground: obstacles, gaps, certificates, steps and ways."""

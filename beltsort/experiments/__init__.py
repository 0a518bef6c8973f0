"""What a researcher runs: the demonstration, and pictures of runs."""

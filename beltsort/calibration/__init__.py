"""Whether decisions are right as often as the belief says, from depth scans, and what makes them differ."""

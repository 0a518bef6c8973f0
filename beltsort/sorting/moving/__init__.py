"""The sorting loop on a belt that never stops, where a decision is a diversion."""

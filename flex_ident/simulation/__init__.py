"""Stage 5: the joint simulated from its recorded motor position."""

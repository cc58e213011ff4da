"""Stage 2: band-limited derivatives without phase shift, the design of their filter, and the first mode."""

"""Stage 2: band-limited derivatives without phase shift, and the design of their filter."""

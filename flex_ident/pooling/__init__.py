"""Several results of one joint as one: what they agree on, what scatters and why, and what a known mass says."""

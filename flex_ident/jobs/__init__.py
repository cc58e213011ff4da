"""Adapter: from a bag to a folder of results, in one call; what commands and nodes share."""

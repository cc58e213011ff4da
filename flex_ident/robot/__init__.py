"""What a robot's description says of one joint."""

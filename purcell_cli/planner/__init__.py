"""Planning: from a start configuration to a goal configuration (section IV-B of the paper)."""

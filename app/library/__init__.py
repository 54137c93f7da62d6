"""Libraries of maps: the instances of many maps in one table, searched as one map is."""
